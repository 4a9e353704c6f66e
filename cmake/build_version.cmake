# Writes the source file of version(): the release, and which sources these are. Run at every build; the file is only
# touched when its text changes, so that a new commit costs one small compilation and the linking.
#   cmake -D SOURCES=... -D VERSION=... -D OUT=... -P build_version.cmake

# What is compiled, wherever git is not there to ask.
file(GLOB_RECURSE files RELATIVE ${SOURCES}
  ${SOURCES}/*_proc/* ${SOURCES}/geometry/* ${SOURCES}/lcmtypes/* ${SOURCES}/platform/* ${SOURCES}/runtime/*
  ${SOURCES}/tools/*)
list(FILTER files INCLUDE REGEX "\\.(cpp|hpp|lcm|cmake|txt)$")
list(SORT files)
set(hashes "")
foreach(file ${files})
  file(SHA256 ${SOURCES}/${file} hash)
  string(APPEND hashes "${file} ${hash}\n")
endforeach()
string(SHA256 hash "${hashes}")
string(SUBSTRING ${hash} 0 12 hash)

# A repository that this tree merely lies in says nothing of it.
execute_process(COMMAND git rev-parse --show-toplevel WORKING_DIRECTORY ${SOURCES}
  OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE no_git)
file(REAL_PATH ${SOURCES} here)
set(which "sources ${hash}")
if(no_git EQUAL 0 AND top STREQUAL here)
  execute_process(COMMAND git rev-parse --short=12 HEAD WORKING_DIRECTORY ${SOURCES}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE no_commit)
  execute_process(COMMAND git --no-optional-locks status --porcelain -- ${files} WORKING_DIRECTORY ${SOURCES}
    OUTPUT_VARIABLE changed ERROR_QUIET RESULT_VARIABLE no_status)
  if(no_commit EQUAL 0 AND no_status EQUAL 0)
    set(which "${commit}")
    if(NOT changed STREQUAL "")
      set(which "${commit}, changed: ${hash}")
    endif()
  endif()
endif()

set(text "#include \"runtime/command_line.hpp\"\n\nconst char* stevedore::version() {\n  return \"${VERSION} (${which})\";\n}\n")
set(before "")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT text STREQUAL before)
  file(WRITE ${OUT} "${text}")
endif()

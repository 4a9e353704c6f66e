# Frame transport: shared-memory ring and inline encodings. A library of its own: it needs no bus.
stevedore_library(frames
  SOURCES ${CMAKE_SOURCE_DIR}/runtime/frame_ring.cpp ${CMAKE_SOURCE_DIR}/runtime/frame_codec.cpp
    ${CMAKE_SOURCE_DIR}/runtime/frame_output.cpp
  PUBLIC lcmtypes opencv_core opencv_imgcodecs rt)

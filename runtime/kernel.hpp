// What the kernel knows of this process.
#pragma once

#include <cstdint>

namespace stevedore {

/// Datagrams the kernel dropped at this process' UDP sockets since they were opened (column "drops" of
/// /proc/net/udp: LCM has no counter of its own).
int64_t kernel_udp_drops();

/// Processor time used so far, user and system.
double cpu_time_s();

/// Resident memory.
double resident_mb();

}  // namespace stevedore

// What the kernel knows of this process.
#pragma once

#include <cstdint>
#include <string>

namespace stevedore {

/// Datagrams the kernel dropped at this process' UDP sockets since they were opened (column "drops" of
/// /proc/net/udp: LCM has no counter of its own).
int64_t kernel_udp_drops();

/// NAME, the number of this network namespace and one for the bus' address in it: shared memory has no
/// namespaces of its own, and two sets that don't hear each other must not share a ring either. A camera that
/// comes back finds, and replaces, its own.
std::string name_in_this_network(const std::string& name, const std::string& bus_url = {});

/// Processor time used so far, user and system.
double cpu_time_s();

/// Resident memory.
double resident_mb();

}  // namespace stevedore

// run FIRST COUNT FOLDER: the runs of COUNT seeds from FIRST on. Of each, the card as it is
// afterwards goes to FOLDER/SEED.bin, what a host fetched from RAM to FOLDER/SEED.ram, and what
// really happened to FOLDER/SEED.truth.
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <new>

#include "world.h"

namespace {

using namespace proof;

Medium medium;
Ram ram;
Truth truth;
tfsat::logger::Block ring[tfsat::logger::kRingBlocks];
alignas(World) uint8_t world_memory[sizeof(World)];

void live(const Scenario& scenario) {
  memset(static_cast<void*>(&truth), 0, sizeof truth);
  memset(world_memory, 0xA5, sizeof world_memory);  // whoever relies on zeros there is found
  memset(ring, 0xA5, sizeof ring);
  ram.blocks = 0;
  (new (world_memory) World(scenario, medium, ram, ring, truth))->live();
}

// In one piece: through semihosting, each call is dear.
bool write_all(int file, const void* bytes, size_t size) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const auto written = write(file, at, size);
    if (written <= 0) return false;
    at += written;
    size -= static_cast<size_t>(written);
  }
  return true;
}

template <typename Records>
bool write_list(int file, const Records& list) {
  return write_all(file, list.items, list.count * sizeof list.items[0]);
}

bool write_image(int file) { return write_all(file, medium.bytes, medium.blocks * kBlockBytes); }

bool write_ram(int file) { return write_all(file, ram.bytes, ram.blocks * kBlockBytes); }

bool write_truth(int file) {
  return write_all(file, &truth.head, sizeof truth.head) && write_list(file, truth.ticks) &&
         write_list(file, truth.writes) && write_list(file, truth.troubles) &&
         write_list(file, truth.edges);
}

bool save(const char* folder, uint32_t seed, const char* suffix, bool (*write_to)(int)) {
  char path[256];
  snprintf(path, sizeof path, "%s/%lu.%s", folder, static_cast<unsigned long>(seed), suffix);
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) return false;
  const bool written = write_to(file);
  return close(file) == 0 && written;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const uint32_t first = static_cast<uint32_t>(strtoul(argv[1], nullptr, 10));
  const uint32_t count = static_cast<uint32_t>(strtoul(argv[2], nullptr, 10));
  for (uint32_t seed = first; seed < first + count; ++seed) {
    const Scenario scenario = scenario_of(seed);
    memset(&medium, 0, sizeof medium);
    if (scenario.holds_older) live(older_of(scenario));
    live(scenario);
    const bool saved = save(argv[3], seed, "bin", write_image) &&
                       save(argv[3], seed, "ram", write_ram) &&
                       save(argv[3], seed, "truth", write_truth);
    if (!saved) return 1;
  }
  return 0;
}

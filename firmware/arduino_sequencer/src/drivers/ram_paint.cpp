#include "ram_paint.h"

#include <avr/io.h>

// Set by the linker: the byte after the last variable.
extern "C" uint8_t __heap_start;

namespace tfsat {
namespace sequencer {

namespace {

constexpr uint8_t kPaint = 0xC5;
// Next to the variables: the stack comes from the other end, as the bootloader's does, whose
// variables lie at the start of RAM. It also clears its key at each start (Caterina.c, bootKeyPtr).
constexpr uint16_t kWitnessBytes = 256;
constexpr uint16_t kBootKeyAddress = 0x0800, kBootKeyBytes = 2;

bool paint_survived __attribute__((section(".noinit")));

}  // namespace

// Part of start-up, before anything is on the stack: all from the last variable to the end
// of RAM is free.
extern "C" void tfsat_paint_free_ram(void) __attribute__((naked, used, section(".init3")));
extern "C" void tfsat_paint_free_ram(void) {
  uint8_t* const first = &__heap_start;
  paint_survived = true;
  for (uint8_t* byte = first; byte < first + kWitnessBytes; ++byte) {
    const bool boot_key = reinterpret_cast<uint16_t>(byte) - kBootKeyAddress < kBootKeyBytes;
    if (!boot_key && *byte != kPaint) paint_survived = false;
  }
  for (uint8_t* byte = first; byte <= reinterpret_cast<uint8_t*>(RAMEND); ++byte) *byte = kPaint;
}

bool RamPaint::survived() { return paint_survived; }

uint16_t RamPaint::ram_never_used_bytes() {
  const uint8_t* const first = &__heap_start;
  const uint8_t* byte = first;
  while (byte <= reinterpret_cast<uint8_t*>(RAMEND) && *byte == kPaint) ++byte;
  return static_cast<uint16_t>(byte - first);
}

}  // namespace sequencer
}  // namespace tfsat

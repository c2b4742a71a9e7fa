// Start and end of a program on QEMU's mps2-an500: FPU on, memory zeroed, arguments and files
// through semihosting (Arm "Semihosting for AArch32 and AArch64", 2.0: SYS_GET_CMDLINE 0x15,
// SYS_EXIT_EXTENDED 0x20).
#pragma GCC diagnostic ignored "-Wpedantic"  // whatever starts main() must call it

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern "C" {
extern uint32_t stack_top, bss_start, bss_end;
void initialise_monitor_handles();
void __libc_init_array();
int main(int argc, char** argv);
void _init() {}
void reset();
}

namespace {

intptr_t semihost(uint32_t operation, void* parameters) {
  register uint32_t r0 __asm__("r0") = operation;
  register void* r1 __asm__("r1") = parameters;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<intptr_t>(r0);
}

[[noreturn]] void end(uint32_t status) {
  uint32_t parameters[] = {0x20026, status};  // ADP_Stopped_ApplicationExit
  semihost(0x20, parameters);
  for (;;) continue;
}

[[noreturn]] void fault() { end(99); }

char command_line[512];
constexpr int kMostArguments = 8;
char* arguments[kMostArguments + 1];

int split_command_line() {
  struct {
    char* buffer;
    uint32_t size;
  } block = {command_line, sizeof command_line};
  if (semihost(0x15, &block) != 0) return 0;
  int count = 0;
  bool in_word = false;
  for (char* at = command_line; *at != 0; ++at) {
    if (*at == ' ') {
      *at = 0;
      in_word = false;
    } else if (!in_word && count < kMostArguments) {
      arguments[count++] = at;
      in_word = true;
    }
  }
  return count;
}

}  // namespace

extern "C" {

__attribute__((section(".vectors"), used)) const void* const vectors[16] = {
    &stack_top, reinterpret_cast<const void*>(&reset), reinterpret_cast<const void*>(&fault),
    reinterpret_cast<const void*>(&fault), reinterpret_cast<const void*>(&fault),
    reinterpret_cast<const void*>(&fault), reinterpret_cast<const void*>(&fault)};

__attribute__((naked, used)) void reset() {
  __asm__ volatile(
      "ldr r0, =0xE000ED88 \n"  // CPACR: full access to the FPU
      "ldr r1, [r0] \n"
      "orr r1, r1, #0xF00000 \n"
      "str r1, [r0] \n"
      "dsb \n"
      "isb \n"
      "b begin \n");
}

__attribute__((used)) void begin() {
  memset(&bss_start, 0,
         static_cast<size_t>(reinterpret_cast<char*>(&bss_end) -
                             reinterpret_cast<char*>(&bss_start)));
  initialise_monitor_handles();
  __libc_init_array();
  const int count = split_command_line();
  end(static_cast<uint32_t>(main(count, arguments)));
}

}

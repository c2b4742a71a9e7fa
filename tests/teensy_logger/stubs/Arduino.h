// Stand-in for the Teensy 4.1 core: declarations only, of exactly the calls and registers that the
// logger's drivers use, so that the board build checks them without the core. Signatures follow
// Teensyduino 1.59; register addresses and bits follow the i.MX RT1060 Processor Reference Manual.
#pragma once

#include <cstddef>
#include <cstdint>

#define HIGH 1
#define LOW 0
#define INPUT_PULLUP 2
#define INPUT_PULLDOWN 3
#define OUTPUT 1
#define OUTPUT_OPENDRAIN 4
#define CHANGE 4
#define RISING 3
#define LED_BUILTIN 13

#define DMAMEM __attribute__((section(".dmabuffers"), used))
#define PROGMEM __attribute__((section(".progmem")))

constexpr uint8_t A0 = 14, A1 = 15, A6 = 20, A7 = 21, A8 = 22, A9 = 23;

extern "C" {
void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
uint8_t digitalRead(uint8_t pin);
void attachInterrupt(uint8_t pin, void (*function)(void), int mode);
int analogRead(uint8_t pin);
void analogReadRes(unsigned int bits);
void analogReadAveraging(unsigned int count);
uint32_t micros(void);
uint32_t millis(void);
void delayMicroseconds(uint32_t us);
}
// Of each pin, the data register of its port; GDIR is the word behind it, DR_SET the 33rd (Reference
// Manual, GPIO memory map).
struct digital_pin_bitband_and_config_table_struct {
  volatile uint32_t* reg;
  volatile uint32_t* mux;
  volatile uint32_t* pad;
  uint32_t mask;
};
extern const digital_pin_bitband_and_config_table_struct digital_pin_to_info_PGM[];
#define digitalPinToBitMask(pin) (digital_pin_to_info_PGM[(pin)].mask)
#define portSetRegister(pin) ((digital_pin_to_info_PGM[(pin)].reg + 33))

inline void analogReadResolution(unsigned int bits) { analogReadRes(bits); }

#define noInterrupts() __asm__ volatile("cpsid i" ::: "memory")
#define interrupts() __asm__ volatile("cpsie i" ::: "memory")

typedef enum { IRQ_GPIO6789 = 157 } IRQ_NUMBER_t;
#define NVIC_SET_PRIORITY(irq, priority) \
  (*reinterpret_cast<volatile uint8_t*>(0xE000E400u + (irq)) = static_cast<uint8_t>(priority))

#define ARM_DWT_CYCCNT (*reinterpret_cast<volatile uint32_t*>(0xE0001004u))
#define HW_OCOTP_CFG0 (*reinterpret_cast<volatile uint32_t*>(0x401F4410u))
#define HW_OCOTP_CFG1 (*reinterpret_cast<volatile uint32_t*>(0x401F4420u))

// LPI2C master registers, in their order and with their gaps.
typedef struct {
  const uint32_t VERID;
  const uint32_t PARAM;
  const uint32_t reserved_08[2];
  volatile uint32_t MCR;
  volatile uint32_t MSR;
  volatile uint32_t MIER;
  volatile uint32_t MDER;
  volatile uint32_t MCFGR0;
  volatile uint32_t MCFGR1;
  volatile uint32_t MCFGR2;
  volatile uint32_t MCFGR3;
  const uint32_t reserved_30[4];
  volatile uint32_t MDMR;
  const uint32_t reserved_44;
  volatile uint32_t MCCR0;
  const uint32_t reserved_4c;
  volatile uint32_t MCCR1;
  const uint32_t reserved_54;
  volatile uint32_t MFCR;
  volatile uint32_t MFSR;
  volatile uint32_t MTDR;
  const uint32_t reserved_64[3];
  volatile uint32_t MRDR;
} IMXRT_LPI2C_t;
static_assert(offsetof(IMXRT_LPI2C_t, MTDR) == 0x60 && offsetof(IMXRT_LPI2C_t, MRDR) == 0x70,
              "Reference Manual, LPI2C memory map");
#define IMXRT_LPI2C1 (*reinterpret_cast<IMXRT_LPI2C_t*>(0x403F0000u))
#define IMXRT_LPI2C3 (*reinterpret_cast<IMXRT_LPI2C_t*>(0x403F8000u))

#define LPI2C_MCR_RRF (static_cast<uint32_t>(1u << 9))
#define LPI2C_MCR_RTF (static_cast<uint32_t>(1u << 8))
#define LPI2C_MCR_MEN (static_cast<uint32_t>(1u << 0))
#define LPI2C_MSR_BBF (static_cast<uint32_t>(1u << 25))
#define LPI2C_MSR_MBF (static_cast<uint32_t>(1u << 24))
#define LPI2C_MSR_PLTF (static_cast<uint32_t>(1u << 13))
#define LPI2C_MSR_FEF (static_cast<uint32_t>(1u << 12))
#define LPI2C_MSR_ALF (static_cast<uint32_t>(1u << 11))
#define LPI2C_MSR_NDF (static_cast<uint32_t>(1u << 10))
#define LPI2C_MSR_SDF (static_cast<uint32_t>(1u << 9))
#define LPI2C_MCFGR1_PRESCALE(n) (static_cast<uint32_t>(((n) & 0x07) << 0))
#define LPI2C_MCFGR2_BUSIDLE(n) (static_cast<uint32_t>(((n) & 0xFFF) << 0))
#define LPI2C_MTDR_CMD_TRANSMIT (static_cast<uint32_t>(0u << 8))
#define LPI2C_MTDR_CMD_RECEIVE (static_cast<uint32_t>(1u << 8))
#define LPI2C_MTDR_CMD_STOP (static_cast<uint32_t>(2u << 8))
#define LPI2C_MTDR_CMD_START (static_cast<uint32_t>(4u << 8))

class usb_serial_class {
 public:
  int read();
  size_t write(const uint8_t* data, size_t size);
  int availableForWrite();
  operator bool();
};
extern usb_serial_class Serial;

class IntervalTimer {
 public:
  using callback_t = void (*)(void);  // 1.59 takes more, but this is what all versions take
  ~IntervalTimer() { end(); }
  template <typename period_t>
  bool begin(callback_t function, period_t period_us) {
    return begin_cycles(function, static_cast<uint32_t>(24.0f * period_us));
  }
  void end();
  void priority(uint8_t level);

 private:
  bool begin_cycles(callback_t function, uint32_t cycles);
};

void setup();
void loop();

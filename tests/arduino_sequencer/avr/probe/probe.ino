// A sketch for testing the emulated Arduino Micro itself; it never goes to the robot.
// Commands, one letter each (numbers little endian):
//   e <byte>               echoes the byte
//   p <channel> <at u16> <width u16>  D9 + channel rises at TCNT1 = at, falls `width` ticks later
//   n                      TCNT1 u16, TCNT3 u16 and MCUSR as it was at start-up
//   c                      count of captures u8, then ICR1 u16, ICR3 u16 and the levels u8
//   w <address u16> <byte> starts one EEPROM byte write
//   b                      EEPE u8
//   r <address u16>        the EEPROM byte there
//   s                      the serial number of the signature row, 10 bytes
//   x                      hangs, so that the watchdog bites
#include <avr/boot.h>
#include <avr/wdt.h>

static uint8_t reset_flags;
static volatile uint16_t width;
static volatile uint8_t captures;
static volatile uint16_t captured[2];

// Set on compare match is COM = 3, clear is COM = 2. The next edge is made by hardware.
static void fall_next(volatile uint16_t& compare, uint8_t shift, uint8_t interrupt) {
  if ((TCCR1A >> shift & 3) == 3) {
    TCCR1A = (TCCR1A & ~(3 << shift)) | (2 << shift);
    compare = compare + width;
  } else {
    TIMSK1 &= ~_BV(interrupt);
  }
}
ISR(TIMER1_COMPA_vect) { fall_next(OCR1A, COM1A0, OCIE1A); }
ISR(TIMER1_COMPB_vect) { fall_next(OCR1B, COM1B0, OCIE1B); }
ISR(TIMER1_COMPC_vect) { fall_next(OCR1C, COM1C0, OCIE1C); }
ISR(TIMER1_CAPT_vect) { captured[0] = ICR1; ++captures; }
ISR(TIMER3_CAPT_vect) { captured[1] = ICR3; ++captures; }

static uint8_t next_byte() {
  int c;
  while ((c = Serial.read()) < 0) wdt_reset();
  return static_cast<uint8_t>(c);
}
static uint16_t next_word() {
  const uint8_t low = next_byte();
  return static_cast<uint16_t>(next_byte() << 8 | low);
}
static void send_word(uint16_t value) {
  Serial.write(static_cast<uint8_t>(value));
  Serial.write(static_cast<uint8_t>(value >> 8));
}

static void arm_pulse(uint8_t channel, uint16_t at) {
  const uint8_t shift = 6 - 2 * channel;
  const uint8_t interrupt = OCIE1A + channel;
  volatile uint16_t& compare = channel == 0 ? OCR1A : channel == 1 ? OCR1B : OCR1C;
  noInterrupts();
  compare = at - 1;  // a match acts at the clock that ends the count
  TIFR1 = _BV(interrupt);
  TCCR1A |= 3 << shift;
  TIMSK1 |= _BV(interrupt);
  interrupts();
}

void setup() {
  reset_flags = MCUSR;
  MCUSR = 0;
  wdt_enable(WDTO_1S);
  DDRB |= _BV(5) | _BV(6) | _BV(7);
  PORTD |= _BV(4);
  PORTC |= _BV(7);
  DDRC &= ~_BV(7);
  noInterrupts();
  GTCCR = _BV(TSM) | _BV(PSRSYNC);
  TCCR1A = TCCR3A = 0;
  TCCR1B = TCCR3B = _BV(CS11) | _BV(ICNC1) | _BV(ICES1);
  TCNT1 = TCNT3 = 0;
  GTCCR = 0;
  TIFR1 = TIFR3 = _BV(ICF1);
  TIMSK1 = TIMSK3 = _BV(ICIE1);
  interrupts();
  Serial.begin(115200);
}

void loop() {
  wdt_reset();
  const int command = Serial.read();
  if (command == 'e') Serial.write(next_byte());
  if (command == 'p') {
    const uint8_t channel = next_byte();
    const uint16_t at = next_word();
    width = next_word();
    arm_pulse(channel, at);
  }
  if (command == 'n') {
    noInterrupts();
    const uint16_t one = TCNT1, three = TCNT3;
    interrupts();
    send_word(one);
    send_word(three);
    Serial.write(reset_flags);
  }
  if (command == 'c') {
    Serial.write(captures);
    send_word(captured[0]);
    send_word(captured[1]);
    Serial.write((PIND >> 4 & 1) | (PINC >> 6 & 2));
  }
  if (command == 'w') {
    EEAR = next_word();
    EEDR = next_byte();
    noInterrupts();
    EECR = _BV(EEMPE);
    EECR |= _BV(EEPE);
    interrupts();
  }
  if (command == 'b') Serial.write(EECR >> EEPE & 1);
  if (command == 'r') {
    EEAR = next_word();
    EECR |= _BV(EERE);
    Serial.write(EEDR);
  }
  if (command == 's') {
    for (uint8_t i = 0; i < 10; ++i) {
      noInterrupts();
      const uint8_t byte = boot_signature_byte_get(0x0E + i);
      interrupts();
      Serial.write(byte);
    }
  }
  if (command == 'x') {
    for (;;) continue;
  }
}

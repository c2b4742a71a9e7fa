// Stand-in for the Teensy core's emulated EEPROM (avr_functions.h); see Arduino.h here.
#pragma once

#include <stdint.h>

extern "C" {
void eeprom_read_block(void* buf, const void* addr, uint32_t len);
void eeprom_write_block(const void* buf, void* addr, uint32_t len);
}

// Bodies for the stand-ins, so that the board build links: they do nothing.
#include <Arduino.h>
#include <SdFat.h>
#include <Wire.h>

usb_serial_class Serial;
TwoWire Wire, Wire1;

extern "C" {
void pinMode(uint8_t, uint8_t) {}
void digitalWrite(uint8_t, uint8_t) {}
uint8_t digitalRead(uint8_t) { return LOW; }
void attachInterrupt(uint8_t, void (*)(void), int) {}
int analogRead(uint8_t) { return 0; }
void analogReadRes(unsigned int) {}
void analogReadAveraging(unsigned int) {}
uint32_t micros(void) { return 0; }
uint32_t millis(void) { return 0; }
void delayMicroseconds(uint32_t) {}
}

int usb_serial_class::read() { return -1; }
size_t usb_serial_class::write(const uint8_t*, size_t) { return 0; }
int usb_serial_class::availableForWrite() { return 0; }
usb_serial_class::operator bool() { return false; }

bool IntervalTimer::begin(void (*)(), float) { return true; }
void IntervalTimer::priority(uint8_t) {}

void TwoWire::begin() {}
void TwoWire::setClock(uint32_t) {}

SdioConfig::SdioConfig(uint8_t) {}
bool SdCard::readCID(cid_t*) { return false; }
bool SdCard::isBusy() { return false; }
bool SdCard::writeSector(uint32_t, const uint8_t*) { return false; }
bool SdCard::syncDevice() { return false; }
bool SdFs::cardBegin(SdioConfig) { return false; }
bool SdFs::volumeBegin() { return false; }
bool SdFs::exists(const char*) { return false; }
SdCard* SdFs::card() { return nullptr; }
bool FsFile::open(SdFs*, const char*, int) { return false; }
bool FsFile::isOpen() const { return false; }
bool FsFile::preAllocate(uint64_t) { return false; }
bool FsFile::seekSet(uint64_t) { return false; }
size_t FsFile::write(const void*, size_t) { return 0; }
bool FsFile::sync() { return false; }
bool FsFile::contiguousRange(uint32_t*, uint32_t*) { return false; }
bool FsFile::truncate(uint64_t) { return false; }
bool FsFile::remove() { return false; }
bool FsFile::close() { return false; }

extern "C" void Reset_Handler() {
  extern void (*__init_array_start[])();
  extern void (*__init_array_end[])();
  for (void (**init)() = __init_array_start; init != __init_array_end; ++init) (*init)();
  setup();
  for (;;) loop();
}

// Bodies for the stand-ins, so that the board build links: they do nothing.
#include <Arduino.h>
#include <SdFat.h>
#include <Wire.h>
#include <avr/eeprom.h>

usb_serial_class Serial;
TwoWire Wire, Wire1;

static volatile uint32_t gpio[36];
const digital_pin_bitband_and_config_table_struct digital_pin_to_info_PGM[] = {
    {gpio, gpio, gpio, 1}};

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
void eeprom_read_block(void*, const void*, uint32_t) {}
void eeprom_write_block(const void*, void*, uint32_t) {}
}

int usb_serial_class::read() { return -1; }
size_t usb_serial_class::write(const uint8_t*, size_t) { return 0; }
int usb_serial_class::availableForWrite() { return 0; }
usb_serial_class::operator bool() { return false; }

bool IntervalTimer::begin_cycles(callback_t, uint32_t) { return true; }
void IntervalTimer::end() {}
void IntervalTimer::priority(uint8_t) {}

void TwoWire::begin() {}
void TwoWire::setClock(uint32_t) {}

SdioConfig::SdioConfig(uint8_t) {}
uint32_t SdCardInterface::status() { return 0; }
uint32_t FsVolume::clusterCount() const { return 0; }
uint32_t FsVolume::fatStartSector() const { return 0; }
uint8_t FsVolume::fatType() const { return 0; }
bool FsVolume::exists(const char*) { return false; }
uint32_t FsVolume::sectorsPerCluster() const { return 0; }
bool SdFs::cardBegin(SdioConfig) { return false; }
bool SdFs::volumeBegin() { return false; }
uint32_t SdFs::freeClusterCount() { return 0; }
SdCard* SdFs::card() { return nullptr; }
bool FsBaseFile::contiguousRange(uint32_t*, uint32_t*) { return false; }
uint64_t FsBaseFile::fileSize() const { return 0; }
size_t FsBaseFile::getName(char*, size_t) { return 0; }
bool FsBaseFile::isOpen() const { return false; }
bool FsBaseFile::open(FsVolume*, const char*, oflag_t) { return false; }
bool FsBaseFile::openNext(FsBaseFile*, oflag_t) { return false; }
bool FsBaseFile::openRoot(FsVolume*) { return false; }
bool FsBaseFile::preAllocate(uint64_t) { return false; }
int FsBaseFile::read(void*, size_t) { return -1; }
bool FsBaseFile::remove() { return false; }
bool FsBaseFile::seekSet(uint64_t) { return false; }
bool FsBaseFile::sync() { return false; }
bool FsBaseFile::truncate(uint64_t) { return false; }
size_t FsBaseFile::write(const void*, size_t) { return 0; }

extern "C" void Reset_Handler() {
  extern void (*__init_array_start[])();
  extern void (*__init_array_end[])();
  for (void (**init)() = __init_array_start; init != __init_array_end; ++init) (*init)();
  setup();
  for (;;) loop();
}

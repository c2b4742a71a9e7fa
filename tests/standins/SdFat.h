// Stand-in for the SdFat library (2.1.2 and later); see Arduino.h here.
#pragma once

#include <Arduino.h>
#include <fcntl.h>

#define FIFO_SDIO 0

class SdioConfig {
 public:
  explicit SdioConfig(uint8_t options);
};

typedef struct {
  uint8_t bytes[16];
} cid_t;

class SdCard {
 public:
  bool readCID(cid_t* cid);
  bool isBusy();
  bool writeSector(uint32_t sector, const uint8_t* data);
  bool syncDevice();
};

class SdFs {
 public:
  bool cardBegin(SdioConfig config);
  bool volumeBegin();
  bool exists(const char* path);
  SdCard* card();
};

class FsFile {
 public:
  bool open(SdFs* volume, const char* path, int flags);
  bool isOpen() const;
  bool preAllocate(uint64_t length);
  bool seekSet(uint64_t position);
  size_t write(const void* data, size_t size);
  bool sync();
  bool contiguousRange(uint32_t* first_sector, uint32_t* last_sector);
  bool truncate(uint64_t length);
  bool remove();
  bool close();
};

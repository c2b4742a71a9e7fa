// Stand-in for the SdFat library as Teensyduino 1.59 ships it (2.1.2); see Arduino.h here. What a
// class inherits stands in the class that declares it.
#pragma once

#include <Arduino.h>
#include <fcntl.h>

typedef int oflag_t;

#define FIFO_SDIO 0
const uint8_t FAT_TYPE_FAT32 = 32;
enum { SD_CARD_ERROR_NONE };

class SdioConfig {
 public:
  explicit SdioConfig(uint8_t options);
};

typedef struct {
  uint8_t bytes[16];
} cid_t;
typedef struct {
  uint8_t bytes[16];
} csd_t;

class FsBlockDeviceInterface {
 public:
  virtual ~FsBlockDeviceInterface() {}
  virtual bool isBusy() = 0;
  virtual bool readSector(uint32_t sector, uint8_t* data) = 0;
  virtual bool syncDevice() = 0;
  virtual bool writeSector(uint32_t sector, const uint8_t* data) = 0;
};

class SdCardInterface : public FsBlockDeviceInterface {
 public:
  virtual uint8_t errorCode() const = 0;
  virtual bool readCID(cid_t* cid) = 0;
  virtual bool readCSD(csd_t* csd) = 0;
  virtual uint32_t status();
};
typedef SdCardInterface SdCard;

class FsVolume {
 public:
  uint32_t clusterCount() const;
  bool exists(const char* path);
  uint32_t fatStartSector() const;
  uint8_t fatType() const;
  uint32_t sectorsPerCluster() const;
};

class SdFs : public FsVolume {
 public:
  bool cardBegin(SdioConfig config);
  bool volumeBegin();
  uint32_t freeClusterCount();
  SdCard* card();
};

class FsBaseFile {
 public:
  bool contiguousRange(uint32_t* first_sector, uint32_t* last_sector);
  uint64_t fileSize() const;
  size_t getName(char* name, size_t size);
  bool isOpen() const;
  bool open(FsVolume* volume, const char* path, oflag_t flags);
  bool openNext(FsBaseFile* directory, oflag_t flags = O_RDONLY);
  bool openRoot(FsVolume* volume);
  bool preAllocate(uint64_t length);
  int read(void* data, size_t size);
  bool remove();
  bool seekSet(uint64_t position);
  bool sync();
  bool truncate(uint64_t length);
  size_t write(const void* data, size_t size);
};
class FsFile : public FsBaseFile {};

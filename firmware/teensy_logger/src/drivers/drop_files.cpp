#include "drop_files.h"

#include <string.h>

#include <new>

namespace tfsat {
namespace logger {

namespace {

constexpr size_t kDigits = 4;
constexpr size_t kPrefix = sizeof "DROP" - 1;

// The number of a name that is ours, or 0.
uint16_t number_of(const char* name) {
  uint16_t number = 0;
  for (size_t i = 0; i < kDigits; ++i) {
    const char digit = name[kPrefix + i];
    if (digit < '0' || digit > '9') return 0;
    number = static_cast<uint16_t>(number * 10 + (digit - '0'));
  }
  return strcmp(name, DropFileName(number).text) == 0 ? number : 0;
}

}  // namespace

DropFileName::DropFileName(uint16_t number) {
  for (size_t i = kDigits; i-- > 0; number = static_cast<uint16_t>(number / 10)) {
    text[kPrefix + i] = static_cast<char>('0' + number % 10);
  }
}

DropFileNumbers find_drop_files(SdFs& volume, uint16_t from) {
  DropFileNumbers found;
  FsFile root;
  FsFile file;
  if (!root.openRoot(&volume)) return found;
  while (file.openNext(&root, O_RDONLY)) {
    char name[sizeof(DropFileName)] = {};
    const size_t length = file.getName(name, sizeof name);
    const uint16_t number = length == sizeof name - 1 ? number_of(name) : 0;
    if (number >= from && number != 0) {
      if (found.lowest == 0 || number < found.lowest) found.lowest = number;
      if (number > found.highest) found.highest = number;
    }
    forget(file);
  }
  return found;
}

void forget(FsFile& file) { new (&file) FsFile; }

}  // namespace logger
}  // namespace tfsat

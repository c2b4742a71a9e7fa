// The recordings' files: DROP0001.BIN to DROP9999.BIN in the card's root directory.
#pragma once

#include <SdFat.h>
#include <stdint.h>

namespace tfsat {
namespace logger {

constexpr uint16_t kFirstDropFile = 1;
constexpr uint16_t kLastDropFile = 9999;

// A file's name as text.
struct DropFileName {
  explicit DropFileName(uint16_t number);
  char text[sizeof "DROP0000.BIN"] = "DROP0000.BIN";
};

// The lowest and the highest number in the directory that are at least `from`; 0 when there is
// none. Reads the whole directory: some milliseconds.
struct DropFileNumbers {
  uint16_t lowest = 0;
  uint16_t highest = 0;
};
DropFileNumbers find_drop_files(SdFs& volume, uint16_t from);

// Makes the object as new. A file is closed so when its card is gone: close() would write to the
// card that is there now, and keeps the object open when it cannot.
void forget(FsFile& file);

}  // namespace logger
}  // namespace tfsat

// Collects an upload, stroke by stroke, where the store takes it from. What is stored is not
// touched.
#pragma once

#include "maneuver.h"
#include "slot_pair.h"

namespace tfsat {
namespace sequencer {

class Upload {
 public:
  explicit Upload(Stored<Maneuver>& store) : store_(store) {}

  Defect begin(uint8_t stroke_count, uint16_t speed_cdeg_s);
  Defect put(uint8_t index, const Stroke& stroke);
  // Everything arrived, the CRC fits and the maneuver is valid; or what is wrong.
  Defect find_defect(uint16_t crc) const;
  bool begun() const { return begun_; }

 private:
  Maneuver collected() const;

  Stored<Maneuver>& store_;
  uint16_t received_ = 0;  // bit i: stroke i is here
  bool begun_ = false;
};

}  // namespace sequencer
}  // namespace tfsat

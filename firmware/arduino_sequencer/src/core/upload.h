// Collects an upload, stroke by stroke, until it is committed. The stored maneuver is not touched.
#pragma once

#include "maneuver.h"

namespace tfsat {
namespace sequencer {

class Upload {
 public:
  Defect begin(uint8_t stroke_count, uint16_t speed_cdeg_s);
  Defect put(uint8_t index, const Stroke& stroke);
  // Everything arrived, the CRC fits and the maneuver is valid; or what is wrong.
  Defect find_defect(uint16_t crc) const;
  const Maneuver& maneuver() const { return maneuver_; }
  bool begun() const { return begun_; }

 private:
  Maneuver maneuver_ = Maneuver::factory();
  uint16_t received_ = 0;  // bit i: stroke i is here
  bool begun_ = false;
};

}  // namespace sequencer
}  // namespace tfsat

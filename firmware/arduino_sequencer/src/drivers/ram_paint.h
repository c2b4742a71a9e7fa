// Free RAM, painted by start-up code. What is still painted later, the stack has never reached; and
// paint from the run before tells whether RAM kept its content through a reset.
#pragma once

#include "../core/ports.h"

namespace tfsat {
namespace sequencer {

class RamPaint : public Health {
 public:
  uint16_t ram_never_used_bytes() override;

  // The paint of the run before was whole at start-up. Without power some of its 2048 bits fall
  // within a fraction of a second, long before those of a short record need to.
  static bool survived();
};

}  // namespace sequencer
}  // namespace tfsat

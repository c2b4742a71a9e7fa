// The maneuver store by itself: torn bytes, worn cells, wear.
#include "../../firmware/arduino_sequencer/src/core/maneuver_store.h"
#include "fake_ports.h"

using namespace tfsat::sequencer;
using tfsat::protocol::ManeuverOrigin;
using tfsat_test::FakeMemory;

namespace {

Maneuver maneuver(int16_t angle_cdeg, uint8_t strokes = 4) {
  Maneuver made = Maneuver::factory();
  made.stroke_count = strokes;
  for (uint8_t i = 0; i < strokes; ++i) {
    const int16_t change = static_cast<int16_t>(i % 2 == 0 ? angle_cdeg : -angle_cdeg);
    made.strokes[i] = Stroke{1, change, 700000u + 100000u * i};
  }
  return made;
}

// Polls until the store rests; false if it never does.
bool finish(ManeuverStore& store) {
  for (int polls = 0; polls < 2000; ++polls) {
    if (!store.writing()) return true;
    store.poll();
  }
  return false;
}

bool store_maneuver(FakeMemory& memory, const Maneuver& wanted) {
  memory.busy_polls = 0;
  ManeuverStore store(memory);
  store.load();
  store.begin(wanted);
  return finish(store) && !store.failed() && store.current() == wanted;
}

}  // namespace

// Every write, every way in which a byte can be torn, over several histories of both slots.
TEST_CASE(power_cut_at_every_write_leaves_the_old_or_the_new) {
  int cuts = 0;
  for (int history = 0; history < 5; ++history) {
    FakeMemory before(history == 4 ? 0x00 : 0xFF);
    Maneuver old = Maneuver::factory();
    for (int i = 0; i < history; ++i) {
      old = maneuver(static_cast<int16_t>(1000 + 100 * i), static_cast<uint8_t>(1 + 3 * i));
      CHECK(store_maneuver(before, old));
    }
    const Maneuver wanted = maneuver(1100, 7);
    FakeMemory dry = before;
    dry.writes = 0;
    CHECK(store_maneuver(dry, wanted));
    CHECK(dry.writes > 4);
    for (int tear = 0; tear < 40; ++tear) {
      for (int at = 1; at <= dry.writes; ++at, ++cuts) {
        FakeMemory memory = before;
        memory.busy_polls = 0;
        memory.writes = 0;
        memory.cut_at_write = at;
        memory.tear = tear;
        {
          ManeuverStore store(memory);
          store.load();
          store.begin(wanted);
          for (int polls = 0; polls < 2000 && !memory.dead; ++polls) store.poll();
        }
        memory.dead = false;
        memory.cut_at_write = 0;
        memory.busy_polls = 0;
        ManeuverStore after(memory);
        after.load();
        const bool is_new = after.current() == wanted;
        CHECK(is_new || after.current() == old);
        if (at < dry.writes) CHECK(!is_new);
        if (at == dry.writes && tear == 1) CHECK(is_new);
        CHECK(store_maneuver(memory, wanted));
      }
    }
  }
  std::printf("  %d cuts\n", cuts);
}

TEST_CASE(a_worn_cell_is_a_failure_and_the_old_maneuver_stays) {
  FakeMemory fresh;
  CHECK(store_maneuver(fresh, maneuver(1000)));
  const Maneuver wanted = maneuver(1234);
  for (int address = 0; address < 2 * ManeuverStore::kSlotBytes; ++address) {
    FakeMemory memory = fresh;
    memory.busy_polls = 0;
    memory.writes = 0;
    memory.worn_address = address;
    ManeuverStore store(memory);
    store.load();
    store.begin(wanted);
    const bool rested = finish(store);
    CHECK(rested);  // a cell that keeps nothing is no reason to write for ever
    CHECK(memory.writes <= ManeuverStore::kSlotBytes + 1);
    if (!rested) continue;
    CHECK(store.failed() || store.current() == wanted);
    if (store.failed()) CHECK(store.current() == maneuver(1000));
    memory.busy_polls = 0;
    ManeuverStore after(memory);
    after.load();
    CHECK(after.current() == store.current());
  }
}

TEST_CASE(what_is_stored_already_is_not_written) {
  FakeMemory memory;
  CHECK(store_maneuver(memory, maneuver(1000)));
  const int writes = memory.writes;
  CHECK(store_maneuver(memory, maneuver(1000)));
  CHECK(memory.writes == writes);
}

TEST_CASE(slots_take_turns) {
  FakeMemory memory;
  for (int i = 0; i < 50; ++i) {
    CHECK(store_maneuver(memory, maneuver(static_cast<int16_t>(500 + i))));
    memory.busy_polls = 0;
    ManeuverStore store(memory);
    store.load();
    CHECK(store.generation() == static_cast<uint32_t>(i + 1));
    CHECK(store.origin() == ManeuverOrigin::kUploaded);
  }
}

// Memory that another sketch left behind, markers and plausible counts included.
TEST_CASE(foreign_memory_is_the_factory_maneuver) {
  std::srand(7);
  for (int round = 0; round < 20000; ++round) {
    FakeMemory memory;
    for (uint8_t& byte : memory.bytes) byte = static_cast<uint8_t>(std::rand());
    for (uint16_t slot = 0; slot < 2; ++slot) {
      const size_t at = slot * ManeuverStore::kSlotBytes;
      memory.bytes[at] = 0xA5;
      memory.bytes[at + 5] = static_cast<uint8_t>(std::rand() % 20);
    }
    ManeuverStore store(memory);
    store.load();
    CHECK(store.current() == Maneuver::factory() && store.origin() == ManeuverOrigin::kFactory);
  }
}

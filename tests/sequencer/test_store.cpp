// A slot pair by itself: torn bytes, worn cells, wear.
#include "../../firmware/arduino_sequencer/src/core/slot_pair.h"
#include "../../firmware/arduino_sequencer/src/core/maneuver.h"
#include "fake_ports.h"

#include <cstring>

using namespace tfsat::sequencer;
using tfsat::protocol::Origin;
using tfsat_test::FakeMemory;
using tfsat_test::same;

namespace {

using Store = Stored<Maneuver>;
constexpr uint16_t kSlotBytes = Store::kBytes / 2;

Maneuver maneuver(int16_t angle_cdeg, uint8_t strokes = 4) {
  Maneuver made = Maneuver::factory();
  made.stroke_count = strokes;
  for (uint8_t i = 0; i < strokes; ++i) {
    const int16_t change = static_cast<int16_t>(i % 2 == 0 ? angle_cdeg : -angle_cdeg);
    made.strokes[i] = Stroke{1, change, 700000u + 100000u * i};
  }
  return made;
}

void begin(Store& store, const Maneuver& wanted) {
  std::memcpy(store.staged(), &wanted, Maneuver::kSize);
  store.begin();
}

// Polls until the store rests; false if it never does.
bool finish(Store& store) {
  for (int polls = 0; polls < 2000; ++polls) {
    if (!store.writing()) return true;
    store.poll();
  }
  return false;
}

bool store_maneuver(FakeMemory& memory, const Maneuver& wanted) {
  memory.busy_polls = 0;
  Store store(memory, 0);
  store.load();
  begin(store, wanted);
  return finish(store) && !store.failed() && same(store.current(), wanted);
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
          Store store(memory, 0);
          store.load();
          begin(store, wanted);
          for (int polls = 0; polls < 2000 && !memory.dead; ++polls) store.poll();
        }
        memory.dead = false;
        memory.cut_at_write = 0;
        memory.busy_polls = 0;
        Store after(memory, 0);
        after.load();
        CHECK(!after.damaged());
        const bool is_new = same(after.current(), wanted);
        CHECK(is_new || same(after.current(), old));
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
  for (int address = 0; address < Store::kBytes; ++address) {
    FakeMemory memory = fresh;
    memory.busy_polls = 0;
    memory.writes = 0;
    memory.worn_address = address;
    Store store(memory, 0);
    store.load();
    begin(store, wanted);
    const bool rested = finish(store);
    CHECK(rested);  // a cell that keeps nothing is no reason to write for ever
    CHECK(memory.writes <= kSlotBytes + 1);
    if (!rested) continue;
    CHECK(store.failed() || same(store.current(), wanted));
    if (store.failed()) CHECK(same(store.current(), maneuver(1000)));
    memory.busy_polls = 0;
    Store after(memory, 0);
    after.load();
    CHECK(same(after.current(), store.current()));
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
    Store store(memory, 0);
    store.load();
    CHECK(store.generation() == static_cast<uint32_t>(i + 1));
    CHECK(store.origin() == Origin::kUploaded);
  }
}

// Memory that another sketch left behind, markers and plausible counts included.
TEST_CASE(foreign_memory_is_the_factory_maneuver) {
  std::srand(7);
  for (int round = 0; round < 20000; ++round) {
    FakeMemory memory;
    for (uint8_t& byte : memory.bytes) byte = static_cast<uint8_t>(std::rand());
    for (uint16_t slot = 0; slot < 2; ++slot) {
      const size_t at = slot * kSlotBytes;
      memory.bytes[at] = 0xA5;
      memory.bytes[at + 5] = static_cast<uint8_t>(std::rand() % 20);
    }
    Store store(memory, 0);
    store.load();
    CHECK(same(store.current(), Maneuver::factory()) && store.origin() == Origin::kFactory);
  }
}

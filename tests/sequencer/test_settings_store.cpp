// Two records in one EEPROM: neither touches the other, whatever power and cells do.
#include <cstring>

#include "bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Answers;
using tfsat_test::Bench;
using tfsat_test::bytes_of;
using tfsat_test::FakeMemory;
using tfsat_test::put;
using tfsat_test::same;
using tfsat_test::same_record;

namespace {

constexpr uint16_t kManeuvers = Sequencer::kManeuverAddress;
constexpr uint16_t kSettings = Sequencer::kSettingsAddress;

Settings settings(uint16_t zero_us) {
  Settings made = Settings::factory();
  made.servo[1].zero_us = zero_us;
  made.servo[2].reversed = 1;
  made.servo[2].zero_us = 2000;
  return made;
}

Maneuver maneuver(int16_t angle_cdeg) {
  Maneuver made = Maneuver::factory();
  made.strokes[0].angle_cdeg = angle_cdeg;
  made.strokes[2].angle_cdeg = static_cast<int16_t>(-angle_cdeg);
  return made;
}

template <typename Record>
Record held(FakeMemory& memory, uint16_t address) {
  memory.busy_polls = 0;
  Stored<Record> store(memory, address);
  store.load();
  return store.current();
}

template <typename Record>
ErrorCode defect(FakeMemory& memory, uint16_t address) {
  Stored<Record> store(memory, address);
  store.load();
  return store.defect();
}

}  // namespace

TEST_CASE(the_stores_lie_apart_and_within_the_eeprom) {
  static_assert(kManeuvers >= SlotPair::kOldLayoutBelow, "the old layout's places are left alone");
  static_assert(kManeuvers + SlotPair::kBytes <= kSettings, "");
  static_assert(kSettings + SlotPair::kBytes <= 1024, "");
  FakeMemory memory;
  for (int round = 0; round < 3; ++round) {  // both slots of both
    const std::vector<uint8_t> before = memory.bytes;
    CHECK(put(memory, kSettings, settings(static_cast<uint16_t>(1100 + round))));
    for (size_t i = 0; i < memory.bytes.size(); ++i) {
      CHECK(i >= kSettings || memory.bytes[i] == before[i]);
    }
    const std::vector<uint8_t> between = memory.bytes;
    CHECK(put(memory, kManeuvers, maneuver(static_cast<int16_t>(4000 + round))));
    for (size_t i = 0; i < memory.bytes.size(); ++i) {
      const bool inside = i >= kManeuvers && i < kManeuvers + SlotPair::kBytes;
      CHECK(inside || memory.bytes[i] == between[i]);
    }
  }
}

TEST_CASE(power_cut_at_every_write_of_settings_leaves_the_old_or_the_new_or_is_told) {
  int cuts = 0;
  for (int history = 0; history < 3; ++history) {
    FakeMemory before;
    CHECK(put(before, kManeuvers, maneuver(4321)));
    Settings old = Settings::factory();
    for (int i = 0; i < history; ++i) {
      old = settings(static_cast<uint16_t>(1010 + i));
      CHECK(put(before, kSettings, old));
    }
    const Settings wanted = settings(1200);
    FakeMemory dry = before;
    dry.writes = 0;
    CHECK(put(dry, kSettings, wanted));
    CHECK(dry.writes > 4);
    for (int tear = 0; tear < 20; ++tear) {
      for (int at = 1; at <= dry.writes; ++at, ++cuts) {
        FakeMemory memory = before;
        memory.writes = 0;
        memory.cut_at_write = at;
        memory.tear = tear;
        put(memory, kSettings, wanted);
        CHECK(memory.dead);
        memory.dead = false;
        memory.cut_at_write = 0;
        const Settings after = held<Settings>(memory, kSettings);
        const ErrorCode told = defect<Settings>(memory, kSettings);
        CHECK(defect<Maneuver>(memory, kManeuvers) == ErrorCode::kNone);
        const bool is_new = same_record(after, wanted);
        if (at < 3) CHECK(told == ErrorCode::kNone);
        if (at > 3 && at < dry.writes) CHECK(told == ErrorCode::kUploadInterrupted);
        CHECK(is_new || same_record(after, old));
        if (at < dry.writes) CHECK(!is_new);
        if (at == dry.writes && tear == 1) CHECK(is_new);
        CHECK(same(held<Maneuver>(memory, kManeuvers), maneuver(4321)));
        CHECK(put(memory, kSettings, wanted));
      }
    }
  }
  std::printf("  %d cuts\n", cuts);
}

TEST_CASE(a_worn_cell_in_one_store_leaves_the_other_alone) {
  FakeMemory fresh;
  CHECK(put(fresh, kManeuvers, maneuver(4000)) && put(fresh, kSettings, settings(1010)));
  for (int address = kManeuvers; address < kSettings + SlotPair::kBytes; ++address) {
    FakeMemory memory = fresh;
    memory.worn_address = address;
    const bool maneuver_kept = put(memory, kManeuvers, maneuver(5555));
    const bool settings_kept = put(memory, kSettings, settings(1234));
    CHECK(maneuver_kept || settings_kept);
    CHECK(address < kSettings ? settings_kept : maneuver_kept);
    CHECK(same(held<Maneuver>(memory, kManeuvers), maneuver(maneuver_kept ? 5555 : 4000)));
    CHECK(same_record(held<Settings>(memory, kSettings), settings(settings_kept ? 1234 : 1010)));
  }
}

// The fake memory complains of whoever touches it during a write.
TEST_CASE(settings_asked_for_while_a_maneuver_is_stored_wait_for_it) {
  Bench bench;
  const Maneuver wanted = maneuver(1000);
  bench.send_strokes(wanted);
  const std::vector<uint8_t> written = bytes_of(settings(1300));
  bench.send_commit(wanted);
  for (int i = 0; i < 200; ++i) {
    bench.send(SettingsWriteRequest::kType, written);
    bench.send_commit(wanted);
    bench.run_ms(1);
  }
  CHECK(bench.core.maneuvers().current().crc() == wanted.crc());
  CHECK(same_record(bench.core.settings().current(), settings(1300)));
  CHECK(bench.core.maneuvers().generation() == 2 && bench.core.settings().generation() == 1);
  const Answers answers(bench.stream.from_board);
  if (!CHECK(answers.types.size() == 6 + 400)) return;
  for (size_t i = 404; i < 406; ++i) {
    CHECK(answers.types[i] != ErrorReply::kType);
    CHECK(answers.payloads[i] == (std::vector<uint8_t>{1, 1}));  // stored, and written
  }
}

// Bits that turn over in the EEPROM: nothing is flown that may not be what was uploaded last.
#include <algorithm>

#include "bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Answers;
using tfsat_test::Bench;
using tfsat_test::FakeMemory;
using tfsat_test::bytes_of;
using tfsat_test::put;
using tfsat_test::same_record;

namespace {

constexpr uint16_t kManeuvers = Sequencer::kManeuverAddress;
constexpr uint16_t kSettings = Sequencer::kSettingsAddress;
constexpr uint16_t kSlotBytes = SlotPair::kSlotBytes;

Maneuver maneuver(int16_t angle_cdeg) {
  Maneuver made = Maneuver::factory();
  made.strokes[0].angle_cdeg = angle_cdeg;
  made.strokes[2].angle_cdeg = static_cast<int16_t>(-angle_cdeg);
  return made;
}

Settings settings(uint16_t zero_us) {
  Settings made = Settings::factory();
  made.servo[1].zero_us = zero_us;
  return made;
}

// Both slots of both stores hold a record, slot 1 the newer.
std::vector<uint8_t> full_eeprom() {
  FakeMemory memory;
  for (const int16_t angle : {4000, 5000}) CHECK(put(memory, kManeuvers, maneuver(angle)));
  for (const uint16_t zero_us : {1010, 1020}) CHECK(put(memory, kSettings, settings(zero_us)));
  return memory.bytes;
}

std::vector<uint8_t> with_flipped_bits(std::vector<size_t> addresses, unsigned bit = 4) {
  std::vector<uint8_t> eeprom = full_eeprom();
  for (const size_t address : addresses) {
    eeprom[address] = static_cast<uint8_t>(eeprom[address] ^ (1u << bit));
  }
  return eeprom;
}

template <typename Record>
bool store(Bench& bench, Stored<Record>& into, const Record& wanted) {
  const std::vector<uint8_t> bytes = bytes_of(wanted);
  std::copy(bytes.begin(), bytes.end(), into.staged());
  into.commit();
  bench.run_ms(100);
  return !into.writing() && !into.failed() && same_record(into.current(), wanted);
}

// Damage is told until a new record heals it, for good. In the marker of the older record it costs
// nothing: the record behind it says that it is older.
template <typename Record>
void check_every_bit(uint16_t address, const Record& older, const Record& newer,
                     const Record& healing, Stored<Record>& (Sequencer::*stored)()) {
  for (uint16_t offset = 0; offset < 2 * kSlotBytes; ++offset) {
    const bool newer_is_hit = offset >= kSlotBytes;
    const bool marker = offset % kSlotBytes < SlotPair::kMarkerBytes;
    if (offset % kSlotBytes >= Stored<Record>::kUsedBytes) continue;
    const bool told = newer_is_hit || !marker;
    for (unsigned bit = 0; bit < 8; ++bit) {
      Bench bench(0, with_flipped_bits({static_cast<size_t>(address + offset)}, bit));
      Stored<Record>& into = (bench.core.*stored)();
      CHECK(same_record(into.current(), newer_is_hit ? older : newer));
      const ErrorCode expected = told ? ErrorCode::kStoreDamaged : ErrorCode::kNone;
      CHECK(into.defect() == expected && bench.arm() == expected);
      CHECK(bench.servos.held == !told);
      bench.core.disarm();
      CHECK(store(bench, into, healing));
      Bench after(bench, ResetCause::kPowerOn);
      for (Bench* healed : {&bench, &after}) {
        CHECK(same_record((healed->core.*stored)().current(), healing));
        CHECK(healed->arm() == ErrorCode::kNone);
      }
    }
  }
}

ErrorCode start_and_arm(const std::vector<uint8_t>& eeprom) {
  Bench bench(0, eeprom);
  return bench.arm();
}

}  // namespace

TEST_CASE(a_flipped_bit_in_a_stored_maneuver_is_told_and_healed) {
  check_every_bit(kManeuvers, maneuver(4000), maneuver(5000), maneuver(5500),
                  &Sequencer::maneuvers);
}

TEST_CASE(a_flipped_bit_in_stored_settings_is_told_and_healed) {
  check_every_bit(kSettings, settings(1010), settings(1020), settings(1030),
                  &Sequencer::settings);
}

// The very maneuver that the other slot still holds is a new record too: it must heal.
TEST_CASE(uploading_the_older_maneuver_again_heals_the_newer) {
  Bench bench(0, with_flipped_bits({kManeuvers + kSlotBytes + 20u}));
  CHECK(same_record(bench.core.maneuvers().current(), maneuver(4000)));
  CHECK(store(bench, bench.core.maneuvers(), maneuver(4000)));
  CHECK(bench.arm() == ErrorCode::kNone);
  CHECK(start_and_arm(bench.memory.bytes) == ErrorCode::kNone);
}

TEST_CASE(damage_in_one_store_is_not_healed_by_the_other) {
  Bench bench(0, with_flipped_bits({kManeuvers + kSlotBytes + 20u, kSettings + 9u}));
  CHECK(store(bench, bench.core.settings(), settings(1200)));
  CHECK(bench.arm() == ErrorCode::kStoreDamaged);
  CHECK(store(bench, bench.core.maneuvers(), maneuver(4500)));
  CHECK(bench.arm() == ErrorCode::kNone);
}

// The host repeats its commit until it hears that the maneuver is stored: by then both slots are.
TEST_CASE(one_upload_heals_both_slots) {
  const std::vector<uint8_t> eeprom = with_flipped_bits({kManeuvers + 20u, kManeuvers + kSlotBytes + 20u});
  Bench bench(0, eeprom);
  CHECK(bench.core.maneuvers().origin() == Origin::kFactory && bench.core.maneuvers().defect() == ErrorCode::kStoreDamaged);
  CHECK(bench.arm() == ErrorCode::kStoreDamaged);
  bench.send_strokes(maneuver(5500));
  bench.run_ms(20);
  const std::vector<uint8_t> not_yet = {0, 1}, stored = {1, 1};
  for (int slot = 0; slot < 2; ++slot) {
    CHECK(bench.arm() == ErrorCode::kStoreDamaged);
    bench.send_commit(maneuver(5500));
    bench.run_ms(100);
    CHECK(Answers(bench.stream.from_board).payloads.back() == not_yet);
  }
  bench.send_commit(maneuver(5500));
  bench.run_ms(100);
  CHECK(Answers(bench.stream.from_board).payloads.back() == stored);
  CHECK(bench.arm() == ErrorCode::kNone);
  CHECK(start_and_arm(bench.memory.bytes) == ErrorCode::kNone);
}

// Whole, but of another layout or senseless: what it was meant to be, nobody knows.
TEST_CASE(a_record_that_is_whole_but_makes_no_sense_is_damage) {
  FakeMemory memory;
  CHECK(put(memory, kManeuvers, maneuver(4000)) && put(memory, kSettings, settings(1010)));
  FakeMemory maneuvers = memory;
  CHECK(!put(maneuvers, kManeuvers, maneuver(9001)));  // the check comes after the write
  CHECK(start_and_arm(maneuvers.bytes) == ErrorCode::kStoreDamaged);
  FakeMemory servo_settings = memory;
  CHECK(!put(servo_settings, kSettings, settings(0)));
  CHECK(start_and_arm(servo_settings.bytes) == ErrorCode::kStoreDamaged);
  CHECK(start_and_arm(memory.bytes) == ErrorCode::kNone);
}

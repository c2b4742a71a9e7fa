// A slot pair alone: torn bytes, worn cells, wear. Then the two pairs of a board.
#include "../fixtures/sequencer/bench.h"

#include <algorithm>
#include <cstring>

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Answers;
using tfsat_test::Bench;
using tfsat_test::ScriptedEeprom;
using tfsat_test::finish;
using tfsat_test::put;
using tfsat_test::same_record;
using tfsat_test::stage;

namespace {

using Store = Stored<Maneuver>;
using Image = ScriptedEeprom::Image;
constexpr uint16_t kManeuvers = Sequencer::kManeuverAddress;
constexpr uint16_t kSettings = Sequencer::kSettingsAddress;
constexpr uint16_t kSlotBytes = Store::kSlotBytes;
constexpr uint8_t kComplete[] = {0x3C, 0x96, 0x3C, 0x96};
constexpr uint32_t kMarkerWrites = 4;

Maneuver maneuver(int16_t angle_cdeg, uint8_t strokes = 4) {
  Maneuver made = Maneuver::factory();
  made.stroke_count = strokes;
  for (uint8_t i = 0; i < strokes; ++i) {
    const int16_t change = static_cast<int16_t>(i % 2 == 0 ? angle_cdeg : -angle_cdeg);
    made.strokes[i] = Stroke{1, change, 700000u + 100000u * i};
  }
  return made;
}

Settings settings(uint16_t zero_us) {
  Settings made = Settings::factory();
  made.servo[1].zero_us = zero_us;
  return made;
}

ScriptedEeprom with_uploads(int count) {
  ScriptedEeprom memory;
  for (int i = 0; i < count; ++i) {
    const uint8_t strokes = static_cast<uint8_t>(1 + 3 * i);
    CHECK(put(memory, kManeuvers, maneuver(static_cast<int16_t>(1000 + 100 * i), strokes)));
  }
  return ScriptedEeprom(memory.image());  // its writes count from here
}

template <typename Record>
struct Held {
  Record record;
  ErrorCode defect;
};

// What the board finds once the power is back.
template <typename Record = Maneuver>
Held<Record> held(ScriptedEeprom& memory, uint16_t address = kManeuvers) {
  memory.restore_power();
  Stored<Record> store(memory, address);
  store.load();
  return {store.current(), store.defect()};
}

// An upload during which the power goes.
Held<Maneuver> held_after_cut(ScriptedEeprom& memory, const Maneuver& wanted, uint32_t at_write, int tear) {
  memory.cut_at_write = at_write;
  memory.tear = tear;
  Store store(memory, kManeuvers);
  store.load();
  store.begin();
  stage(store, wanted);
  finish(store, memory);
  return held(memory);
}

}  // namespace

// Every write, every way in which a byte can be torn, over several histories of both slots. The marker
// says "begun" from its third byte on. Of the last write, torn, nobody can tell whether it was the
// last of an upload or damage to a whole record.
TEST_CASE(power_cut_at_every_write_leaves_the_old_or_the_new_or_is_told) {
  int cuts = 0;
  for (int history = 0; history < 4; ++history) {
    const ScriptedEeprom before = with_uploads(history);
    ScriptedEeprom old_memory = before;
    const Maneuver old = held(old_memory).record;
    const Maneuver wanted = maneuver(1100, 7);
    ScriptedEeprom dry = before;
    CHECK(put(dry, kManeuvers, wanted));
    CHECK(dry.writes() > 3 * kMarkerWrites);
    for (int tear = 0; tear < 16; ++tear) {
      for (uint32_t at = 1; at <= dry.writes(); ++at, ++cuts) {
        ScriptedEeprom memory = before;
        const Held<Maneuver> after = held_after_cut(memory, wanted, at, tear);
        const bool is_new = same_record(after.record, wanted);
        CHECK(is_new || same_record(after.record, old));
        CHECK(is_new == (after.defect == ErrorCode::kNone && at == dry.writes()));
        if (at < 3) CHECK(after.defect == ErrorCode::kNone);
        if (at > 3 && at < dry.writes()) CHECK(after.defect == ErrorCode::kUploadInterrupted);
        if (at == 3 && tear <= 1) CHECK((after.defect == ErrorCode::kNone) == (tear == 0));
        if (at == dry.writes() && tear == 0) CHECK(after.defect == ErrorCode::kUploadInterrupted);
        if (at == dry.writes() && tear == 1) CHECK(is_new);
        CHECK(put(memory, kManeuvers, wanted));
      }
    }
  }
  std::printf("  %d cuts\n", cuts);
}

// The cable dies half way: whatever comes then, a commit alone gives something to fly.
TEST_CASE(an_upload_begun_counts_until_a_commit_even_after_power_cuts) {
  for (int history = 0; history < 3; ++history) {
    ScriptedEeprom memory = with_uploads(history);
    {
      Store store(memory, kManeuvers);
      store.load();
      store.begin();
      CHECK(store.defect() == ErrorCode::kUploadInterrupted);
      CHECK(finish(store, memory) && memory.writes() == kMarkerWrites);
      store.begin();  // a second copy
      CHECK(finish(store, memory) && memory.writes() == kMarkerWrites);
      CHECK(store.defect() == ErrorCode::kUploadInterrupted);
    }
    for (int start = 0; start < 2; ++start) {
      CHECK(held(memory).defect == ErrorCode::kUploadInterrupted);
    }
    ScriptedEeprom same_again = memory;
    const Maneuver old = held(memory).record;
    CHECK(put(same_again, kManeuvers, old) && put(memory, kManeuvers, maneuver(1100, 7)));
    CHECK(same_record(held(same_again).record, old));
    CHECK(held(same_again).defect == ErrorCode::kNone && held(memory).defect == ErrorCode::kNone);
  }
}

TEST_CASE(the_upload_of_what_is_stored_leaves_every_byte_as_it_was) {
  for (int history = 1; history < 4; ++history) {
    ScriptedEeprom memory = with_uploads(history);
    const Image before = memory.image();
    const Maneuver old = held(memory).record;
    Store store(memory, kManeuvers);
    store.load();
    store.begin();
    CHECK(finish(store, memory) && memory.image() != before);
    stage(store, old);
    CHECK(finish(store, memory) && !store.changed() && !store.failed());
    CHECK(store.defect() == ErrorCode::kNone && memory.image() == before);
    CHECK(memory.writes() == 2 * kMarkerWrites);
    for (uint32_t at = 1; at <= 2 * kMarkerWrites; ++at) {
      for (int tear = 0; tear < 20; ++tear) {
        ScriptedEeprom cut = with_uploads(history);
        const Held<Maneuver> after = held_after_cut(cut, old, at, tear);
        CHECK(same_record(after.record, old));
        CHECK(after.defect == ErrorCode::kNone || after.defect == ErrorCode::kUploadInterrupted);
        if (at < 3 || at > kMarkerWrites + 2) CHECK(after.defect == ErrorCode::kNone);
        CHECK(put(cut, kManeuvers, old));
      }
    }
  }
}

// What the board did with a marker lost whole: it took the slot for one that was never written.
TEST_CASE(never_written_means_that_all_of_the_slot_is_erased) {
  ScriptedEeprom memory = with_uploads(2);
  for (const int fill : {0xFF, 0x00}) {
    ScriptedEeprom lost = memory;
    std::memset(&lost.image()[kManeuvers + kSlotBytes], fill, kMarkerWrites);
    CHECK(held(lost).defect == ErrorCode::kStoreDamaged);
  }
  ScriptedEeprom erased = memory;
  std::memset(&erased.image()[kManeuvers + kSlotBytes], 0xFF, kSlotBytes);
  CHECK(held(erased).defect == ErrorCode::kNone);
}

// Layout 1, as firmware up to 0.1.0 wrote it: marker, generation, record, CRC, from address 0 on.
TEST_CASE(a_store_of_the_old_layout_is_named_until_something_is_uploaded) {
  const Maneuver flown = maneuver(1000);
  ScriptedEeprom memory;
  memory.image()[0] = 0xA5;
  memory.image()[1] = 1;
  std::memcpy(&memory.image()[5], &flown, Maneuver::kSize);
  CHECK(held(memory).defect == ErrorCode::kStoreOldLayout);
  CHECK(same_record(held(memory).record, Maneuver::factory()));
  for (int byte = 0; byte < 256; ++byte) {  // whatever is left of it
    ScriptedEeprom rest;
    rest.image()[static_cast<size_t>(byte)] = 0x00;
    CHECK(held(rest).defect == ErrorCode::kStoreOldLayout);
  }
  ScriptedEeprom cut = memory;
  {
    Store store(cut, kManeuvers);
    store.load();
    store.begin();
    CHECK(store.defect() == ErrorCode::kUploadInterrupted && finish(store, cut));
  }
  CHECK(held(cut).defect == ErrorCode::kUploadInterrupted);
  const std::vector<uint8_t> old_bytes(memory.image().begin(), memory.image().begin() + kManeuvers);
  CHECK(put(memory, kManeuvers, flown) && held(memory).defect == ErrorCode::kNone);
  CHECK(std::equal(old_bytes.begin(), old_bytes.end(), memory.image().begin()));
}

namespace {

// A record as an earlier and as a later firmware knows it.
template <uint8_t kBytes>
struct Record {
  static constexpr size_t kSize = kBytes;
  uint8_t bytes[kBytes];
  static Record factory() { return Record{}; }
  bool decode(const uint8_t* from, size_t size) {
    std::memcpy(bytes, from, size);
    return true;
  }
  bool valid() const { return true; }
};

}  // namespace

TEST_CASE(a_record_that_grew_reads_what_is_stored_and_zeros_for_the_rest) {
  ScriptedEeprom memory;
  const uint8_t stored[] = {1, 2, 3, 4, 5};
  Stored<Record<5>> earlier(memory, kManeuvers);
  earlier.load();
  std::memcpy(earlier.staged(), stored, sizeof stored);
  earlier.commit();
  CHECK(finish(earlier, memory));
  Stored<Record<8>> later(memory, kManeuvers);
  later.load();
  CHECK(later.defect() == ErrorCode::kNone && later.generation() == 1);
  const uint8_t read[] = {1, 2, 3, 4, 5, 0, 0, 0};
  CHECK(std::memcmp(later.current().bytes, read, sizeof read) == 0);
  std::memcpy(later.staged(), read, sizeof read);
  later.commit();  // in the new length
  CHECK(later.changed());
  CHECK(finish(later, memory));
  CHECK(later.generation() == 2 && later.defect() == ErrorCode::kNone);
  Stored<Record<5>> gone_back(memory, kManeuvers);
  gone_back.load();  // what the longer record means, it does not know
  CHECK(gone_back.defect() == ErrorCode::kStoreDamaged);
}

// Memory that another sketch left behind, markers and plausible counts included.
TEST_CASE(foreign_memory_is_damage_and_the_factory_maneuver) {
  std::srand(7);
  for (int round = 0; round < 5000; ++round) {
    ScriptedEeprom memory;
    for (uint8_t& byte : memory.image()) byte = static_cast<uint8_t>(std::rand());
    for (uint16_t slot = 0; slot < 2; ++slot) {
      const size_t at = kManeuvers + slot * kSlotBytes;
      std::memcpy(&memory.image()[at], kComplete, sizeof kComplete);
      memory.image()[at + 4] = static_cast<uint8_t>(std::rand() % 20);
      memory.image()[at + 8] = 2;
      memory.image()[at + 9] = static_cast<uint8_t>(std::rand() % 120);
    }
    CHECK(held(memory).defect == ErrorCode::kStoreDamaged);
    CHECK(same_record(held(memory).record, Maneuver::factory()));
    if (round < 20) CHECK(put(memory, kManeuvers, maneuver(1000)));
  }
}

// Two records in one EEPROM, as the board has them, and bits that turn over in it: nothing is flown that may not be
// what was uploaded last.
namespace {

// Both slots of both stores hold a record, slot 1 the newer.
Image full_eeprom() {
  ScriptedEeprom memory;
  for (const int16_t angle : {1200, 1300}) CHECK(put(memory, kManeuvers, maneuver(angle)));
  for (const uint16_t zero_us : {1010, 1020}) CHECK(put(memory, kSettings, settings(zero_us)));
  return memory.image();
}

Image with_flipped_bits(std::vector<size_t> addresses, unsigned bit = 4) {
  Image eeprom = full_eeprom();
  for (const size_t address : addresses) {
    eeprom[address] = static_cast<uint8_t>(eeprom[address] ^ (1u << bit));
  }
  return eeprom;
}

template <typename Record>
bool store(Bench& bench, Stored<Record>& into, const Record& wanted) {
  stage(into, wanted);
  bench.finish_storing();
  return !into.writing() && !into.failed() && same_record(into.current(), wanted);
}

// Damage is told until a new record heals it, for good. In the marker of the older record it costs
// nothing: the record behind it says that it is older.
template <typename Record>
void check_every_bit(uint16_t address, const Record& older, const Record& newer,
                     const Record& third, Stored<Record>& (Sequencer::*stored)()) {
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
      const Record& healing = bit % 2 == 0 ? third : older;  // what the other slot holds is a new record, too
      CHECK(store(bench, into, healing));
      Bench after(bench, ResetCause::kPowerOn);
      for (Bench* healed : {&bench, &after}) {
        CHECK(same_record((healed->core.*stored)().current(), healing));
        CHECK(healed->arm() == ErrorCode::kNone);
      }
    }
  }
}

ErrorCode start_and_arm(const Image& eeprom) {
  Bench bench(0, eeprom);
  return bench.arm();
}

}  // namespace

TEST_CASE(the_stores_lie_apart_and_within_the_eeprom) {
  static_assert(kManeuvers >= SlotPair::kOldLayoutBelow, "the old layout's places are left alone");
  static_assert(kManeuvers + SlotPair::kBytes <= kSettings, "");
  static_assert(kSettings + SlotPair::kBytes <= 1024, "");
  ScriptedEeprom memory;
  for (int round = 0; round < 3; ++round) {  // both slots of both
    const Image before = memory.image();
    CHECK(put(memory, kSettings, settings(static_cast<uint16_t>(1100 + round))));
    for (size_t i = 0; i < memory.image().size(); ++i) {
      CHECK(i >= kSettings || memory.image()[i] == before[i]);
    }
    const Image between = memory.image();
    CHECK(put(memory, kManeuvers, maneuver(static_cast<int16_t>(1200 + round))));
    for (size_t i = 0; i < memory.image().size(); ++i) {
      const bool inside = i >= kManeuvers && i < kManeuvers + SlotPair::kBytes;
      CHECK(inside || memory.image()[i] == between[i]);
    }
  }
}

// A cell that keeps nothing is a failure, no reason to write for ever, and the other store's business never.
TEST_CASE(a_worn_cell_in_one_store_leaves_the_old_record_and_the_other_store_alone) {
  ScriptedEeprom fresh;
  CHECK(put(fresh, kManeuvers, maneuver(1200)) && put(fresh, kSettings, settings(1010)));
  for (int address = kManeuvers; address < kSettings + SlotPair::kBytes; ++address) {
    ScriptedEeprom memory(fresh.image());
    memory.worn_address = address;
    const bool maneuver_kept = put(memory, kManeuvers, maneuver(1400));
    CHECK(memory.writes() <= kSlotBytes + 2 * kMarkerWrites);
    const bool settings_kept = put(memory, kSettings, settings(1234));
    CHECK(maneuver_kept || settings_kept);
    CHECK(address < kSettings ? settings_kept : maneuver_kept);
    const Held<Maneuver> maneuvers = held(memory);
    CHECK(same_record(maneuvers.record, maneuver(maneuver_kept ? 1400 : 1200)));
    CHECK((maneuvers.defect == ErrorCode::kNone) == maneuver_kept);
    CHECK(same_record(held<Settings>(memory, kSettings).record, settings(settings_kept ? 1234 : 1010)));
  }
}

TEST_CASE(a_flipped_bit_in_a_stored_maneuver_is_told_and_healed) {
  check_every_bit(kManeuvers, maneuver(1200), maneuver(1300), maneuver(1400),
                  &Sequencer::maneuvers);
}

TEST_CASE(a_flipped_bit_in_stored_settings_is_told_and_healed) {
  check_every_bit(kSettings, settings(1010), settings(1020), settings(1030),
                  &Sequencer::settings);
}

// The host repeats its commit until it hears that the maneuver is stored: by then both slots are.
TEST_CASE(one_upload_heals_both_slots) {
  const Image eeprom = with_flipped_bits({kManeuvers + 20u, kManeuvers + kSlotBytes + 20u});
  Bench bench(0, eeprom);
  const Stored<Maneuver>& maneuvers = bench.core.maneuvers();
  CHECK(maneuvers.origin() == Origin::kFactory && maneuvers.defect() == ErrorCode::kStoreDamaged);
  CHECK(bench.arm() == ErrorCode::kStoreDamaged);
  bench.send_strokes(maneuver(1400));
  bench.run_ms(20);
  const std::vector<uint8_t> not_yet = {0, 1}, stored = {1, 1};
  for (int slot = 0; slot < 2; ++slot) {
    CHECK(bench.arm() == ErrorCode::kStoreDamaged);
    bench.send_commit(maneuver(1400));
    bench.finish_storing();
    CHECK(Answers(bench.received).payloads.back() == not_yet);
  }
  bench.send_commit(maneuver(1400));
  bench.finish_storing();
  CHECK(Answers(bench.received).payloads.back() == stored);
  CHECK(bench.arm() == ErrorCode::kNone);
  CHECK(start_and_arm(bench.eeprom.image()) == ErrorCode::kNone);
}

// Whole, but of another layout or senseless: what it was meant to be, nobody knows.
TEST_CASE(a_record_that_is_whole_but_makes_no_sense_is_damage) {
  ScriptedEeprom memory;
  CHECK(put(memory, kManeuvers, maneuver(1200)) && put(memory, kSettings, settings(1010)));
  ScriptedEeprom maneuvers = memory;
  CHECK(!put(maneuvers, kManeuvers, maneuver(9001)));  // the check comes after the write
  CHECK(start_and_arm(maneuvers.image()) == ErrorCode::kStoreDamaged);
  ScriptedEeprom servo_settings = memory;
  CHECK(!put(servo_settings, kSettings, settings(0)));
  CHECK(start_and_arm(servo_settings.image()) == ErrorCode::kStoreDamaged);
  CHECK(start_and_arm(memory.image()) == ErrorCode::kNone);
}

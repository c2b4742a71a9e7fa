// A slot pair alone: torn bytes, worn cells, wear. Then the two pairs of a board.
#include "bench.h"

#include <algorithm>
#include <cstring>

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

using Store = Stored<Maneuver>;
constexpr uint16_t kAddress = 512;
constexpr uint16_t kSlotBytes = Store::kSlotBytes;
constexpr uint8_t kComplete[] = {0x3C, 0x96, 0x3C, 0x96};
constexpr int kMarkerWrites = 4;

Maneuver maneuver(int16_t angle_cdeg, uint8_t strokes = 4) {
  Maneuver made = Maneuver::factory();
  made.stroke_count = strokes;
  for (uint8_t i = 0; i < strokes; ++i) {
    const int16_t change = static_cast<int16_t>(i % 2 == 0 ? angle_cdeg : -angle_cdeg);
    made.strokes[i] = Stroke{1, change, 700000u + 100000u * i};
  }
  return made;
}

// An upload: the board is told of it, gets it, and stores it.
void upload(Store& store, const Maneuver& wanted) {
  store.begin();
  std::memcpy(store.staged(), &wanted, Maneuver::kSize);
  store.commit();
}

// Polls until the store rests; false if it never does.
bool finish(Store& store) {
  for (int polls = 0; polls < 2000; ++polls) {
    if (!store.writing()) return true;
    store.poll();
  }
  return false;
}

// As a host does it: repeats its commit until there is nothing left to write.
bool store_maneuver(FakeMemory& memory, const Maneuver& wanted) {
  memory.busy_polls = 0;
  Store store(memory, kAddress);
  store.load();
  upload(store, wanted);
  do {
    if (!finish(store) || store.failed()) return false;
    store.commit();
  } while (store.changed());
  return store.defect() == ErrorCode::kNone && same(store.current(), wanted);
}

FakeMemory with_uploads(int count) {
  FakeMemory memory;
  for (int i = 0; i < count; ++i) {
    const uint8_t strokes = static_cast<uint8_t>(1 + 3 * i);
    CHECK(store_maneuver(memory, maneuver(static_cast<int16_t>(1000 + 100 * i), strokes)));
  }
  memory.busy_polls = memory.writes = 0;
  return memory;
}

struct Held {
  Maneuver maneuver;
  ErrorCode defect;
};

// What the board finds once the power is back.
Held held(FakeMemory& memory) {
  memory.dead = false;
  memory.busy_polls = memory.cut_at_write = 0;
  Store store(memory, kAddress);
  store.load();
  return Held{store.current(), store.defect()};
}

}  // namespace

// Every write, every way in which a byte can be torn, over several histories of both slots. The marker
// says "begun" from its third byte on. Of the last write, torn, nobody can tell whether it was the
// last of an upload or damage to a whole record.
TEST_CASE(power_cut_at_every_write_leaves_the_old_or_the_new_or_is_told) {
  int cuts = 0;
  for (int history = 0; history < 4; ++history) {
    const FakeMemory before = with_uploads(history);
    FakeMemory old_memory = before;
    const Maneuver old = held(old_memory).maneuver;
    const Maneuver wanted = maneuver(1100, 7);
    FakeMemory dry = before;
    CHECK(store_maneuver(dry, wanted));
    CHECK(dry.writes > 3 * kMarkerWrites);
    for (int tear = 0; tear < 16; ++tear) {
      for (int at = 1; at <= dry.writes; ++at, ++cuts) {
        FakeMemory memory = before;
        memory.cut_at_write = at;
        memory.tear = tear;
        {
          Store store(memory, kAddress);
          store.load();
          upload(store, wanted);
          for (int polls = 0; polls < 2000 && !memory.dead; ++polls) store.poll();
        }
        const Held after = held(memory);
        const bool is_new = same(after.maneuver, wanted);
        CHECK(is_new || same(after.maneuver, old));
        CHECK(is_new == (after.defect == ErrorCode::kNone && at == dry.writes));
        if (at < 3) CHECK(after.defect == ErrorCode::kNone);
        if (at > 3 && at < dry.writes) CHECK(after.defect == ErrorCode::kUploadInterrupted);
        if (at == 3 && tear <= 1) CHECK((after.defect == ErrorCode::kNone) == (tear == 0));
        if (at == dry.writes && tear == 0) CHECK(after.defect == ErrorCode::kUploadInterrupted);
        if (at == dry.writes && tear == 1) CHECK(is_new);
        CHECK(store_maneuver(memory, wanted));
      }
    }
  }
  std::printf("  %d cuts\n", cuts);
}

// The cable dies half way: whatever comes then, a commit alone gives something to fly.
TEST_CASE(an_upload_begun_counts_until_a_commit_even_after_power_cuts) {
  for (int history = 0; history < 3; ++history) {
    FakeMemory memory = with_uploads(history);
    {
      Store store(memory, kAddress);
      store.load();
      store.begin();
      CHECK(store.defect() == ErrorCode::kUploadInterrupted);
      CHECK(finish(store) && memory.writes == kMarkerWrites);
      store.begin();  // a second copy
      CHECK(finish(store) && memory.writes == kMarkerWrites);
      CHECK(store.defect() == ErrorCode::kUploadInterrupted);
    }
    for (int start = 0; start < 2; ++start) {
      CHECK(held(memory).defect == ErrorCode::kUploadInterrupted);
    }
    FakeMemory same_again = memory;
    const Maneuver old = held(memory).maneuver;
    CHECK(store_maneuver(same_again, old) && store_maneuver(memory, maneuver(1100, 7)));
    CHECK(same(held(same_again).maneuver, old));
    CHECK(held(same_again).defect == ErrorCode::kNone && held(memory).defect == ErrorCode::kNone);
  }
}

TEST_CASE(the_upload_of_what_is_stored_leaves_every_byte_as_it_was) {
  for (int history = 1; history < 4; ++history) {
    FakeMemory memory = with_uploads(history);
    const std::vector<uint8_t> before = memory.bytes;
    const Maneuver old = held(memory).maneuver;
    Store store(memory, kAddress);
    store.load();
    store.begin();
    CHECK(finish(store) && memory.bytes != before);
    std::memcpy(store.staged(), &old, Maneuver::kSize);
    store.commit();
    CHECK(finish(store) && !store.changed() && !store.failed());
    CHECK(store.defect() == ErrorCode::kNone && memory.bytes == before);
    CHECK(memory.writes == 2 * kMarkerWrites);
    for (int at = 1; at <= 2 * kMarkerWrites; ++at) {
      for (int tear = 0; tear < 20; ++tear) {
        FakeMemory cut = with_uploads(history);
        cut.cut_at_write = at;
        cut.tear = tear;
        Store torn(cut, kAddress);
        torn.load();
        upload(torn, old);
        for (int polls = 0; polls < 100 && !cut.dead; ++polls) torn.poll();
        const Held after = held(cut);
        CHECK(same(after.maneuver, old));
        CHECK(after.defect == ErrorCode::kNone || after.defect == ErrorCode::kUploadInterrupted);
        if (at < 3 || at > kMarkerWrites + 2) CHECK(after.defect == ErrorCode::kNone);
        CHECK(store_maneuver(cut, old));
      }
    }
  }
}

// What the board did with a marker lost whole: it took the slot for one that was never written.
TEST_CASE(never_written_means_that_all_of_the_slot_is_erased) {
  FakeMemory memory = with_uploads(2);
  for (const int fill : {0xFF, 0x00}) {
    FakeMemory lost = memory;
    std::memset(&lost.bytes[kAddress + kSlotBytes], fill, kMarkerWrites);
    CHECK(held(lost).defect == ErrorCode::kStoreDamaged);
  }
  FakeMemory erased = memory;
  std::memset(&erased.bytes[kAddress + kSlotBytes], 0xFF, kSlotBytes);
  CHECK(held(erased).defect == ErrorCode::kNone);
}

// Layout 1, as firmware up to 0.1.0 wrote it: marker, generation, record, CRC, from address 0 on.
TEST_CASE(a_store_of_the_old_layout_is_named_until_something_is_uploaded) {
  const Maneuver flown = maneuver(1000);
  FakeMemory memory;
  memory.bytes[0] = 0xA5;
  memory.bytes[1] = 1;
  std::memcpy(&memory.bytes[5], &flown, Maneuver::kSize);
  CHECK(held(memory).defect == ErrorCode::kStoreOldLayout);
  CHECK(same(held(memory).maneuver, Maneuver::factory()));
  for (int byte = 0; byte < 256; ++byte) {  // whatever is left of it
    FakeMemory rest;
    rest.bytes[static_cast<size_t>(byte)] = 0x00;
    CHECK(held(rest).defect == ErrorCode::kStoreOldLayout);
  }
  FakeMemory cut = memory;
  {
    Store store(cut, kAddress);
    store.load();
    store.begin();
    CHECK(store.defect() == ErrorCode::kUploadInterrupted && finish(store));
  }
  CHECK(held(cut).defect == ErrorCode::kUploadInterrupted);
  const std::vector<uint8_t> old_bytes(memory.bytes.begin(), memory.bytes.begin() + kAddress);
  CHECK(store_maneuver(memory, flown) && held(memory).defect == ErrorCode::kNone);
  CHECK(std::equal(old_bytes.begin(), old_bytes.end(), memory.bytes.begin()));
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
  FakeMemory memory;
  const uint8_t stored[] = {1, 2, 3, 4, 5};
  Stored<Record<5>> earlier(memory, kAddress);
  earlier.load();
  std::memcpy(earlier.staged(), stored, sizeof stored);
  earlier.commit();
  for (int polls = 0; polls < 200; ++polls) earlier.poll();
  Stored<Record<8>> later(memory, kAddress);
  later.load();
  CHECK(later.defect() == ErrorCode::kNone && later.generation() == 1);
  const uint8_t read[] = {1, 2, 3, 4, 5, 0, 0, 0};
  CHECK(std::memcmp(later.current().bytes, read, sizeof read) == 0);
  std::memcpy(later.staged(), read, sizeof read);
  later.commit();  // in the new length
  CHECK(later.changed());
  for (int polls = 0; polls < 200; ++polls) later.poll();
  CHECK(later.generation() == 2 && later.defect() == ErrorCode::kNone);
  Stored<Record<5>> gone_back(memory, kAddress);
  gone_back.load();  // what the longer record means, it does not know
  CHECK(gone_back.defect() == ErrorCode::kStoreDamaged);
}

TEST_CASE(a_worn_cell_is_a_failure_and_the_old_maneuver_stays) {
  FakeMemory fresh;
  CHECK(store_maneuver(fresh, maneuver(1000)));
  const Maneuver wanted = maneuver(1234);
  for (int address = kAddress; address < kAddress + Store::kBytes; ++address) {
    FakeMemory memory = fresh;
    memory.busy_polls = 0;
    memory.writes = 0;
    memory.worn_address = address;
    Store store(memory, kAddress);
    store.load();
    upload(store, wanted);
    const bool rested = finish(store);
    CHECK(rested);  // a cell that keeps nothing is no reason to write for ever
    CHECK(memory.writes <= kSlotBytes + kMarkerWrites);
    if (!rested) continue;
    CHECK(store.failed() || same(store.current(), wanted));
    if (store.failed()) {
      CHECK(same(store.current(), maneuver(1000)));
      CHECK(store.defect() == ErrorCode::kStoreDamaged);
    }
    CHECK(same(held(memory).maneuver, store.current()));
  }
}

// Memory that another sketch left behind, markers and plausible counts included.
TEST_CASE(foreign_memory_is_damage_and_the_factory_maneuver) {
  std::srand(7);
  for (int round = 0; round < 5000; ++round) {
    FakeMemory memory;
    for (uint8_t& byte : memory.bytes) byte = static_cast<uint8_t>(std::rand());
    for (uint16_t slot = 0; slot < 2; ++slot) {
      const size_t at = kAddress + slot * kSlotBytes;
      std::memcpy(&memory.bytes[at], kComplete, sizeof kComplete);
      memory.bytes[at + 4] = static_cast<uint8_t>(std::rand() % 20);
      memory.bytes[at + 8] = 2;
      memory.bytes[at + 9] = static_cast<uint8_t>(std::rand() % 120);
    }
    CHECK(held(memory).defect == ErrorCode::kStoreDamaged);
    CHECK(same(held(memory).maneuver, Maneuver::factory()));
    if (round < 20) CHECK(store_maneuver(memory, maneuver(1000)));
  }
}

// Two records in one EEPROM, as the board has them, and bits that turn over in it: nothing is flown that may not be
// what was uploaded last.
namespace {

constexpr uint16_t kManeuvers = Sequencer::kManeuverAddress;
constexpr uint16_t kSettings = Sequencer::kSettingsAddress;

Maneuver flown(int16_t angle_cdeg) {
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
  for (const int16_t angle : {4000, 5000}) CHECK(put(memory, kManeuvers, flown(angle)));
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

template <typename Record>
Record current(FakeMemory& memory, uint16_t address) {
  memory.busy_polls = 0;
  Stored<Record> store(memory, address);
  store.load();
  return store.current();
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
    CHECK(put(memory, kManeuvers, flown(static_cast<int16_t>(4000 + round))));
    for (size_t i = 0; i < memory.bytes.size(); ++i) {
      const bool inside = i >= kManeuvers && i < kManeuvers + SlotPair::kBytes;
      CHECK(inside || memory.bytes[i] == between[i]);
    }
  }
}

TEST_CASE(a_worn_cell_in_one_store_leaves_the_other_alone) {
  FakeMemory fresh;
  CHECK(put(fresh, kManeuvers, flown(4000)) && put(fresh, kSettings, settings(1010)));
  for (int address = kManeuvers; address < kSettings + SlotPair::kBytes; ++address) {
    FakeMemory memory = fresh;
    memory.worn_address = address;
    const bool maneuver_kept = put(memory, kManeuvers, flown(5555));
    const bool settings_kept = put(memory, kSettings, settings(1234));
    CHECK(maneuver_kept || settings_kept);
    CHECK(address < kSettings ? settings_kept : maneuver_kept);
    CHECK(same(current<Maneuver>(memory, kManeuvers), flown(maneuver_kept ? 5555 : 4000)));
    CHECK(same_record(current<Settings>(memory, kSettings), settings(settings_kept ? 1234 : 1010)));
  }
}

TEST_CASE(a_flipped_bit_in_a_stored_maneuver_is_told_and_healed) {
  check_every_bit(kManeuvers, flown(4000), flown(5000), flown(5500),
                  &Sequencer::maneuvers);
}

TEST_CASE(a_flipped_bit_in_stored_settings_is_told_and_healed) {
  check_every_bit(kSettings, settings(1010), settings(1020), settings(1030),
                  &Sequencer::settings);
}

// The very maneuver that the other slot still holds is a new record too: it must heal.
TEST_CASE(uploading_the_older_maneuver_again_heals_the_newer) {
  Bench bench(0, with_flipped_bits({kManeuvers + kSlotBytes + 20u}));
  CHECK(same_record(bench.core.maneuvers().current(), flown(4000)));
  CHECK(store(bench, bench.core.maneuvers(), flown(4000)));
  CHECK(bench.arm() == ErrorCode::kNone);
  CHECK(start_and_arm(bench.memory.bytes) == ErrorCode::kNone);
}

// The host repeats its commit until it hears that the maneuver is stored: by then both slots are.
TEST_CASE(one_upload_heals_both_slots) {
  const std::vector<uint8_t> eeprom = with_flipped_bits({kManeuvers + 20u, kManeuvers + kSlotBytes + 20u});
  Bench bench(0, eeprom);
  CHECK(bench.core.maneuvers().origin() == Origin::kFactory && bench.core.maneuvers().defect() == ErrorCode::kStoreDamaged);
  CHECK(bench.arm() == ErrorCode::kStoreDamaged);
  bench.send_strokes(flown(5500));
  bench.run_ms(20);
  const std::vector<uint8_t> not_yet = {0, 1}, stored = {1, 1};
  for (int slot = 0; slot < 2; ++slot) {
    CHECK(bench.arm() == ErrorCode::kStoreDamaged);
    bench.send_commit(flown(5500));
    bench.run_ms(100);
    CHECK(Answers(bench.stream.from_board).payloads.back() == not_yet);
  }
  bench.send_commit(flown(5500));
  bench.run_ms(100);
  CHECK(Answers(bench.stream.from_board).payloads.back() == stored);
  CHECK(bench.arm() == ErrorCode::kNone);
  CHECK(start_and_arm(bench.memory.bytes) == ErrorCode::kNone);
}

// Whole, but of another layout or senseless: what it was meant to be, nobody knows.
TEST_CASE(a_record_that_is_whole_but_makes_no_sense_is_damage) {
  FakeMemory memory;
  CHECK(put(memory, kManeuvers, flown(4000)) && put(memory, kSettings, settings(1010)));
  FakeMemory maneuvers = memory;
  CHECK(!put(maneuvers, kManeuvers, flown(9001)));  // the check comes after the write
  CHECK(start_and_arm(maneuvers.bytes) == ErrorCode::kStoreDamaged);
  FakeMemory servo_settings = memory;
  CHECK(!put(servo_settings, kSettings, settings(0)));
  CHECK(start_and_arm(servo_settings.bytes) == ErrorCode::kStoreDamaged);
  CHECK(start_and_arm(memory.bytes) == ErrorCode::kNone);
}

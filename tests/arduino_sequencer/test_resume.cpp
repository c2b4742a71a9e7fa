// Resets: what RAM must look like to be believed, and what a believed past may lead to; the last run's report in it.
#include <cstddef>
#include <cstring>
#include <numeric>
#include <random>

#include "../fixtures/sequencer/bench.h"

using namespace tfsat::sequencer;
using namespace tfsat::protocol;
using tfsat_test::Bench;

namespace {

// Bits of what the checksum covers, and of itself; the interrupts' count keeps its own complement,
// the run's report its own checksum.
std::vector<size_t> sealed_bits() {
  std::vector<size_t> bits(8 * (offsetof(RetainedState, crc) + sizeof RetainedState().crc));
  std::iota(bits.begin(), bits.end(), size_t{0});
  return bits;
}

constexpr uint16_t kStartPoseTicks = 2000;
const ResetCause kCauses[] = {ResetCause::kExternal, ResetCause::kBrownOut, ResetCause::kWatchdog,
                              ResetCause::kUnknown};

void flip(RetainedState& state, size_t bit) {
  uint8_t bytes[sizeof state];
  std::memcpy(bytes, &state, sizeof state);
  bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ (1u << (bit % 8)));
  std::memcpy(&state, bytes, sizeof state);
}

RetainedState filled(uint8_t byte) {
  uint8_t bytes[sizeof(RetainedState)];
  std::memset(bytes, byte, sizeof bytes);
  RetainedState state;
  std::memcpy(&state, bytes, sizeof state);
  return state;
}

// Both contacts open for a millisecond.
void knock(Bench& bench) {
  bench.open_both();
  bench.run_ms(1);
  bench.close_both();
  bench.run_ms(20);
}

void check_held(const Bench& bench, uint16_t joint_1, uint16_t joint_2, uint16_t joint_3) {
  CHECK(bench.servos.held && bench.servos.changes.empty());
  CHECK(bench.servos.widths[0] == joint_1);
  CHECK(bench.servos.widths[1] == joint_2);
  CHECK(bench.servos.widths[2] == joint_3);
}

// A release at `now` whose second contact closes and opens `bounces` times more, 0.3 ms apart.
void bounce_open(Bench& bench, int bounces) {
  bench.open_both();
  for (int i = 0; i < 2 * bounces; ++i) {
    bench.pass(600);
    bench.switches.set(1, i % 2 != 0, bench.now());
    bench.poll();
  }
  bench.run_ms(10);
  CHECK(bench.is(SequencerState::kRunning));
}

std::vector<uint8_t> told(const Bench& bench) {
  std::vector<uint8_t> payload(RunReportReply::kSize);
  bench.core.run_report().encode(payload.data());
  return payload;
}

}  // namespace

TEST_CASE(retained_state_with_one_or_two_flipped_bits_is_not_intact) {
  Bench bench;
  bench.wait_armed();
  const std::vector<size_t> bits = sealed_bits();
  CHECK(bits.size() == 20 * 8);  // no padding that the checksum would not cover
  CHECK(bench.retained.intact());
  for (const size_t a : bits) {
    for (const size_t b : bits) {
      RetainedState damaged = bench.retained;
      flip(damaged, a);
      if (b != a) flip(damaged, b);
      CHECK(!damaged.intact());
    }
  }
}

// A supply that dips may damage the EEPROM, markers included.
TEST_CASE(a_record_that_the_reset_damaged_is_not_replaced_by_an_older_one) {
  for (const int address : {0, 10}) {
    for (const bool running : {false, true}) {
      Bench before;
      before.wait_armed();
      if (running) before.open_both();
      before.run_ms(20);
      before.eeprom.image().at(static_cast<size_t>(Sequencer::kManeuverAddress + address)) ^= 0x10;
      Bench bench(before, ResetCause::kBrownOut);
      bench.run_ms(20);
      CHECK(bench.is(SequencerState::kFault, ErrorCode::kStoreDamaged));
      bench.open_both();
      bench.run_ms(3000);
      CHECK(!bench.servos.held && bench.servos.changes.empty());
      CHECK(bench.core.state() == SequencerState::kFault);
    }
  }
}

TEST_CASE(ram_after_power_on_is_not_intact) {
  for (int byte = 0; byte < 256; ++byte) CHECK(!filled(static_cast<uint8_t>(byte)).intact());
  std::mt19937 random(22);
  int believed = 0;
  for (int round = 0; round < 200000; ++round) {
    uint8_t bytes[sizeof(RetainedState)];
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    RetainedState state;
    std::memcpy(&state, bytes, sizeof state);
    believed += state.intact() ? 1 : 0;
  }
  std::printf("  %d of 200000 random images pass 16 bits of CRC; 3 are expected\n", believed);
  CHECK(believed <= 12);
}

TEST_CASE(damaged_ram_starts_safe_and_silent) {
  Bench before;
  before.wait_armed();
  for (const size_t bit : sealed_bits()) {
    Bench damaged(before, ResetCause::kWatchdog);
    damaged.retained = before.retained;
    flip(damaged.retained, bit);
    Bench bench(damaged, ResetCause::kWatchdog);
    bench.run_ms(20);
    CHECK(bench.core.state() == SequencerState::kSafe && bench.core.fault() == ErrorCode::kNone);
    CHECK(!bench.servos.held && bench.core.resets_while_armed() == 0);
  }
}

TEST_CASE(a_lost_supply_is_believed_more_than_ram) {
  Bench before;
  before.wait_armed();
  Bench bench(before, ResetCause::kPowerOn);
  bench.run_ms(20);
  CHECK(bench.core.state() == SequencerState::kSafe && !bench.servos.held);
}

TEST_CASE(armed_again_only_after_the_debounce) {
  for (const ResetCause cause : kCauses) {
    Bench before;
    before.wait_armed();
    knock(before);
    Bench bench(before, cause);
    check_held(bench, kStartPoseTicks, kStartPoseTicks, kStartPoseTicks);
    CHECK(bench.core.knocks() == 1);
    const tick_t started_at = bench.now();
    while (bench.core.state() == SequencerState::kSafe &&
           bench.now() - started_at < 20 * kTicksPerMs) {
      CHECK(!bench.core.may_upload());
      CHECK(bench.arm() == ErrorCode::kWrongState);
      bench.pass(100);
      bench.poll();
    }
    CHECK(bench.core.state() == SequencerState::kArmed);
    CHECK(bench.now() - started_at == ticks_from_us(kReleaseDebounceUs));
    CHECK(bench.core.resets_while_armed() == 1);
    bench.open_both();
    const tick_t released_at = bench.now();
    bench.run_ms(10);
    CHECK(bench.core.state() == SequencerState::kRunning);
    if (CHECK(bench.servos.changes.size() == 4)) {
      CHECK(bench.servos.changes[0].at == released_at + ticks_from_us(700000));
    }
  }
}

TEST_CASE(a_switch_that_bounces_in_the_debounce_after_a_reset_is_a_fault) {
  for (uint32_t at = 0; at < ticks_from_us(kReleaseDebounceUs); at += 200) {
    for (const uint8_t index : {0, 1}) {
      Bench before;
      before.wait_armed();
      Bench bench(before, ResetCause::kBrownOut);
      const tick_t started_at = bench.now();
      for (; bench.now() - started_at < 10 * kTicksPerMs; bench.pass(100)) {
        const tick_t passed = bench.now() - started_at;
        if (passed == at) bench.switches.set(index, true, bench.now());
        if (passed == at + 200) bench.switches.set(index, false, bench.now());
        bench.poll();
      }
      CHECK(bench.is(SequencerState::kFault, ErrorCode::kResetWhileArmed));
      check_held(bench, kStartPoseTicks, kStartPoseTicks, kStartPoseTicks);
    }
  }
}

// Of such a switch only the closing edge is ever seen.
TEST_CASE(a_switch_that_closes_before_the_first_look_after_a_reset_was_open) {
  for (const uint8_t index : {0, 1}) {
    Bench before;
    before.wait_armed();
    before.switches.set(index, true, before.now());
    Bench bench(before, ResetCause::kWatchdog);
    bench.switches.set(index, false, bench.now());
    bench.run_ms(20);
    CHECK(bench.is(SequencerState::kFault, ErrorCode::kResetWhileArmed));
    check_held(bench, kStartPoseTicks, kStartPoseTicks, kStartPoseTicks);
  }
}

TEST_CASE(disarming_right_after_a_reset_is_safe) {
  Bench before;
  before.wait_armed();
  Bench bench(before, ResetCause::kWatchdog);
  bench.core.disarm();
  bench.run_ms(20);
  CHECK(bench.core.state() == SequencerState::kSafe && !bench.servos.held);
  Bench again(bench, ResetCause::kWatchdog);
  again.run_ms(20);
  CHECK(again.core.state() == SequencerState::kSafe && !again.servos.held);
}

// Every subset of the strokes, noted by the main loop, or begun while it hung.
TEST_CASE(a_reset_while_running_holds_the_strokes_begun) {
  const uint16_t open_ticks[] = {3311, 3556};
  const int16_t open_cdeg[] = {5900, 7000};
  for (const bool hung : {false, true}) {
    for (uint16_t begun = 0; begun < 16; ++begun) {
      Bench before;
      before.fly(20);
      before.strokes_begin(begun);
      if (!hung) before.run_ms(1);
      Bench bench(before, ResetCause::kWatchdog);
      bench.run_ms(3000);
      CHECK(bench.is(SequencerState::kFault, ErrorCode::kResetWhileRunning));
      Bench again(bench, ResetCause::kWatchdog);
      for (Bench* board : {&bench, &again}) {
        // Open where the joint's stroke out has begun, and not the one back: strokes 0 and 2, 1 and 3.
        uint16_t widths[2];
        for (int joint = 0; joint < 2; ++joint) {
          const bool open = (begun >> joint & 5) == 1;
          widths[joint] = open ? open_ticks[joint] : kStartPoseTicks;
          CHECK(board->core.held_cdeg()[joint] == (open ? open_cdeg[joint] : 0));
        }
        check_held(*board, widths[0], widths[1], kStartPoseTicks);
        CHECK(board->core.driven() == 7);
        uint8_t count = 0;
        for (uint8_t i = 0; i < kMaxStrokes; ++i) {
          const uint32_t told_us = board->core.run_report().start_us[i];
          if ((begun >> i & 1) == 0) {
            CHECK(told_us == kStrokeNotBegunUs);
            continue;
          }
          ++count;
          CHECK(told_us == (hung ? kStrokeTimeUnknownUs : Maneuver::factory().strokes[i].start_us));
        }
        CHECK(board->core.strokes_started() == count);
        CHECK(board->core.run_report().stroke_count == 4);
      }
    }
  }
}

// Limp rather than at an angle that nobody knows: bits that their complement contradicts.
TEST_CASE(marks_of_strokes_that_make_no_sense_move_nothing) {
  for (uint32_t flips = 1; flips < 0x10000; flips += flips < 64 ? 1 : 61) {
    Bench before;
    before.fly(20);
    before.strokes_begin(5);
    before.retained.begun.bits = static_cast<uint16_t>(before.retained.begun.bits ^ flips);
    Bench bench(before, ResetCause::kWatchdog);
    bench.run_ms(1);
    CHECK(bench.core.fault() == ErrorCode::kResetWhileRunning);
    CHECK(!bench.servos.held && bench.core.driven() == 0);
  }
}

// With the maneuver gone nobody knows what the marks are of: no stroke is noted by them, and a servo
// without pulses has no angle.
TEST_CASE(a_reset_while_running_with_a_damaged_store_invents_no_stroke) {
  for (const uint16_t flips : {0, 4, 0xFFFF}) {
    Bench before;
    before.fly(20);
    before.strokes_begin(1);
    before.run_ms(1);
    before.retained.begun.bits = static_cast<uint16_t>(before.retained.begun.bits ^ flips);
    for (uint16_t at = 0; at < 2 * SlotPair::kSlotBytes; at += SlotPair::kSlotBytes) {
      before.eeprom.image()[Sequencer::kManeuverAddress + at + 10u] ^= 0x10;
    }
    Bench bench(before, ResetCause::kBrownOut);
    bench.run_ms(5);
    CHECK(bench.core.fault() == ErrorCode::kStoreDamaged);
    CHECK(bench.core.driven() == 0 && !bench.servos.held);
    for (const int16_t angle_cdeg : bench.core.held_cdeg()) CHECK(angle_cdeg == 0);
    const RunReportReply& report = bench.core.run_report();
    CHECK(report.start_us[0] == Maneuver::factory().strokes[0].start_us);
    for (uint8_t i = 1; i < kMaxStrokes; ++i) CHECK(report.start_us[i] == kStrokeNotBegunUs);
  }
}

TEST_CASE(resets_are_counted_up_to_255) {
  Bench first;
  first.wait_armed();
  Bench* board = new Bench(first, ResetCause::kWatchdog);
  for (int number = 1; number <= 300; ++number) {
    CHECK(board->core.resets_while_armed() == (number < 255 ? number : 255));
    board->run_ms(6);
    CHECK(board->core.state() == SequencerState::kArmed);
    Bench* after = new Bench(*board, ResetCause::kWatchdog);
    delete board;
    board = after;
  }
  delete board;
}

// Whatever the RAM held at power-on, and in every state that lives on SAFE.
TEST_CASE(no_token_comes_back_after_a_reset) {
  for (const uint16_t left_in_ram : {0x0000, 0x0001, 0xFFFF, 0x1234}) {
    Bench dark;
    dark.retained.token = left_in_ram;
    Bench before(dark, ResetCause::kPowerOn);
    const uint16_t token = before.core.arm_token();
    Bench once(before, ResetCause::kWatchdog);
    Bench twice(once, ResetCause::kWatchdog);
    twice.run_ms(20);
    CHECK(once.core.arm_token() != token);
    CHECK(twice.core.arm_token() != token && twice.core.arm_token() != once.core.arm_token());
    for (const uint16_t old_token : {token, once.core.arm_token()}) {
      CHECK(twice.core.arm(old_token, twice.now()) == ErrorCode::kStaleToken);
    }
    CHECK(twice.core.state() == SequencerState::kSafe);
  }
}

// At any tick of a millisecond, on any clock: the report and uptime_ms tell the same time.
TEST_CASE(the_release_is_told_on_the_clock_of_uptime) {
  for (tick_t offset = 0; offset < kTicksPerMs; offset += 37) {
    for (const int32_t before_turn_ms : {0, 10, 25, 60000}) {
      Bench bench(static_cast<tick_t>(-before_turn_ms * static_cast<int32_t>(kTicksPerMs)));
      bench.wait_armed();
      bench.pass(offset);
      bounce_open(bench, 2);
      const RunReportReply& report = bench.core.run_report();
      CHECK(report.released == 1 && report.bounces == 5 && report.stroke_count == 4);
      CHECK(report.release_us < 1000);
      CHECK_NEAR(1000.0 * report.release_ms + report.release_us, 20000.0 + us_from_ticks(offset), 1);
      for (const uint32_t start_us : report.start_us) CHECK(start_us == kStrokeNotBegunUs);
    }
  }
}

// Its checksum is its own: neither the report's damage nor the state's takes the other along.
TEST_CASE(a_report_with_a_flipped_bit_is_no_report) {
  Bench flown;
  flown.wait_armed();
  bounce_open(flown, 3);
  flown.first_strokes_begin(2);
  flown.run_ms(1);
  const size_t size = sizeof(RunReportReply) + sizeof(uint16_t);
  for (size_t bit = 0; bit < 8 * size; ++bit) {
    Bench damaged(flown, ResetCause::kWatchdog);
    damaged.retained = flown.retained;
    uint8_t* bytes = reinterpret_cast<uint8_t*>(&damaged.retained.run);
    bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ (1u << (bit % 8)));
    Bench bench(damaged, ResetCause::kWatchdog);
    // The strokes that the interrupts marked are known all the same, but not when they began.
    CHECK(bench.core.run_report().released == 0);
    CHECK(bench.core.fault() == ErrorCode::kResetWhileRunning);
    CHECK(bench.core.strokes_started() == 2);
    CHECK(bench.core.run_report().start_us[1] == kStrokeTimeUnknownUs);
    Bench again(bench, ResetCause::kWatchdog);
    CHECK(again.core.run_report().released == 0 && again.core.strokes_started() == 2);
  }
  Bench forgetful(flown, ResetCause::kWatchdog);
  forgetful.retained = flown.retained;
  forgetful.retained.crc = static_cast<uint16_t>(~forgetful.retained.crc);
  Bench bench(forgetful, ResetCause::kWatchdog);
  CHECK(bench.core.state() == SequencerState::kSafe && told(bench) == told(flown));
}

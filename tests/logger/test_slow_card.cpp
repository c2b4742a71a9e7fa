#include "shared_processor.h"

using namespace tfsat_test;
using tfsat::logger::kRingBlocks;

namespace {

constexpr uint32_t kDearNs = 30000;
constexpr uint16_t kFactoryMib = kFileFactoryMib;

}  // namespace

TEST_CASE(the_factory_file_is_recorded_at_every_rate_whatever_blocks_cost) {
  for (const uint16_t rate_hz : {280, 900, 1000}) {
    SharedProcessor bench(rate_hz, kFactoryMib, kDearNs, 0);
    bench.run_ms(11000);
    CHECK(bench.records_all() && bench.blocks_to_spare() > kRingBlocks / 2);
    CHECK(bench.stop().samples_dropped == 0 && bench.log().footers.size() == 1);
  }
}

TEST_CASE(likewise_when_one_block_in_a_hundred_stalls) {
  for (const uint16_t rate_hz : {280, 1000}) {
    SharedProcessor bench(rate_hz, kFactoryMib, kDearNs, 100);
    bench.run_ms(15000);
    CHECK(bench.records_all() && bench.blocks_to_spare() > kRingBlocks / 4);
  }
}

TEST_CASE(what_is_recorded_while_the_file_is_filled_is_soon_safe) {
  SharedProcessor bench(1000, kFactoryMib, kDearNs, 0);
  for (int i = 0; i < 12; ++i) {
    bench.run_ms(470);
    emulator::BlockDevice cut = bench.card;
    cut.power_cut(emulator::PowerCut::kLosesCache);
    CHECK(bench.recording_on(cut).samples.size() + 600 > bench.status().samples);
  }
}

TEST_CASE(a_drop_right_after_the_start_is_recorded_whole_and_twice) {
  for (const uint64_t after_ms : {50, 1500}) {
    SharedProcessor bench(1000, kFactoryMib, kDearNs, 0);
    bench.run_ms(after_ms);
    bench.release();
    bench.run_ms(2500);
    bench.land();
    bench.run_ms(7000);
    CHECK(bench.status().state == LoggerState::kStopped && bench.status().samples_dropped == 0);
    const Recording log = bench.log();
    CHECK(log.footers.size() == 1 && log.footers[0].blocks_rewritten > 500);
    CHECK(log.sample_indices.back() + 1 == log.samples.size());
  }
}

TEST_CASE(the_next_file_is_filled_at_1_khz_while_the_robot_waits) {
  SharedProcessor bench(1000, 4, kDearNs, 0);
  const uint32_t first = bench.status().session;
  while (bench.status().session == first && bench.t_us < 60000000) bench.run_ms(100);
  bench.run_ms(9000);
  CHECK(bench.status().session != first && bench.records_all());
  CHECK(bench.blocks_to_spare() > kRingBlocks / 2);
}

TEST_CASE(a_card_that_is_counted_for_4_s_leaves_no_request_without_an_answer) {
  BoardBench bench;
  for (const bool card_changed : {false, true}) {
    bench.card.set_mount_us(4000000);
    if (card_changed) {
      bench.card.set_present(false);
      bench.run_ms(2500);
      bench.card.set_present(true);
    } else {
      bench.board.set_power(false);
      bench.board.set_power(true);
    }
    bench.run_ms(2100);  // the card is looked at every 2 s
    for (int i = 0; i < 60; ++i) {
      CHECK(bench.status().card == CardState::kUnknown);
      CHECK(bench.get<HelloReply>(HelloRequest::kType).board == Board::kLogger);
      CHECK(bench.refused(RecordStartRequest{7, 0}).code == ErrorCode::kBusy);
      CHECK(bench.refused(LogListRequest{0}).code == ErrorCode::kBusy);
    }
    bench.run_ms(3000);
    CHECK(bench.status().card == CardState::kReady);
  }
  CHECK(bench.start(7).state == LoggerState::kRecording);
  bench.run_ms(1000);
  CHECK(bench.stop().samples_dropped == 0);
}

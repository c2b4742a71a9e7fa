// The log server between a recorder, a card with made-up files and a host at the end of a real
// link.
#pragma once

#include <cstring>
#include <map>

#include "../../firmware/teensy_logger/src/core/log_server.h"
#include "fake_ports.h"
#include "recorder_bench.h"

namespace tfsat_test {

using namespace tfsat::logger;
using namespace tfsat::protocol;

struct NoRequests final : RequestHandler {
  Reply handle(uint8_t, const uint8_t*, size_t, uint8_t*) override {
    return Reply::refused(ErrorCode::kUnknownMessage);
  }
};

constexpr uint64_t kUnixUs = 1790000000000000u;

// A recording as the builder makes it: header, `n_data` blocks, footer.
inline std::vector<Block> recording_of(uint32_t session, uint32_t n_data) {
  std::vector<Block> memory(n_data + 4);
  BlockRing ring(memory.data(), n_data + 4);
  BlockBuilder builder(ring);
  builder.begin(session, LogHeader(), kUnixUs, 10000);
  for (uint32_t i = 0; i < n_data * kSamplesPerBlock; ++i) builder.add_sample(i * 1000, Sample());
  builder.add_footer(0, LogFooter());
  memory.resize(ring.committed());
  return memory;
}

struct LogBench {
  LogBench() : server(archive, recorder.recorder), link(stream, no_requests) {}

  LogListReply list(uint16_t from) { return server.list(from); }
  ErrorCode read(uint16_t number, uint32_t session, uint32_t first, uint16_t count) {
    LogReadRequest request = {};
    request.number = number;
    request.session = session;
    request.first_block = first;
    request.count = count;
    announced = 0;
    return server.begin_read(request, announced);
  }
  // Passes of the main loop, in each of which the host's driver takes some bytes.
  void run(size_t bytes_a_pass = SIZE_MAX) {
    for (int pass = 0, idle = 0; idle < 4 && pass < 200000; ++pass) {
      stream.room = bytes_a_pass;
      const size_t before = stream.bytes.size();
      link.poll();
      for (int i = 0; i < 16 && server.poll(link); ++i) continue;
      idle = stream.bytes.size() == before ? idle + 1 : 0;
    }
    receive();
  }
  void receive() {
    FrameReceiver<kMaxPayloadBytes> receiver;
    for (const uint8_t byte : stream.bytes) {
      if (!receiver.feed(byte)) continue;
      ++frames;
      if (receiver.type() == LogPartStream::kType) {
        LogPartStream part;
        CHECK(part.decode(receiver.payload(), receiver.payload_bytes()));
        std::memcpy(blocks[part.block].bytes + part.part * kLogPartBytes, part.data, kLogPartBytes);
        ++parts[part.block];
      } else {
        LogZerosStream zeros;
        CHECK(receiver.type() == LogZerosStream::kType);
        CHECK(zeros.decode(receiver.payload(), receiver.payload_bytes()));
        for (uint32_t i = 0; i < zeros.count; ++i) {
          blocks[zeros.first_block + i] = Block();
          parts[zeros.first_block + i] += 8;
        }
      }
    }
    CHECK(receiver.rejected() == 0);
    stream.bytes.clear();
  }
  bool got(const std::vector<Block>& file, uint32_t first, uint32_t count) {
    bool same = blocks.size() == count;
    for (uint32_t i = first; same && i < first + count; ++i) {
      same = parts[i] == 8 && std::memcmp(blocks[i].bytes, file[i].bytes, kBlockBytes) == 0;
    }
    return same;
  }
  void forget() {
    blocks.clear();
    parts.clear();
    frames = 0;
  }

  ScriptedCard archive;
  RecorderBench recorder{RecorderBench::kPeriodUs, 64};
  LogServer server;
  FakeStream stream;
  NoRequests no_requests;
  Link link;
  uint16_t announced = 0;
  std::map<uint32_t, Block> blocks;
  std::map<uint32_t, int> parts;
  int frames = 0;
};

}  // namespace tfsat_test

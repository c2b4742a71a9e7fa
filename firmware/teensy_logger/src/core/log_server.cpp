#include "log_server.h"

#include <string.h>

#include "../protocol/crc32.h"

namespace tfsat {
namespace logger {

using protocol::BlockHeader;
using protocol::BlockKind;
using protocol::ErrorCode;
using protocol::LogEntry;

protocol::LogListReply LogServer::list(uint16_t from) {
  protocol::LogListReply reply = {};
  uint16_t number = 0;
  uint32_t n_blocks = 0;
  if (from == kRam && find(kRam, reply.entry)) {
    reply.found = 1;
  } else if (archive_.find(from == kRam ? 1 : from, number, n_blocks)) {
    reply.found = 1;
    reply.entry = describe(number, n_blocks);
  }
  return reply;
}

bool LogServer::find(uint16_t number, LogEntry& entry) {
  if (number == kRam) {
    const uint32_t n_blocks = recorder_.ram_blocks();
    if (n_blocks == 0) return false;
    entry = describe(kRam, n_blocks);
    entry.session = recorder_.session();
    return true;
  }
  uint16_t found = 0;
  uint32_t n_blocks = 0;
  if (!archive_.find(number, found, n_blocks) || found != number) return false;
  entry = describe(number, n_blocks);
  return true;
}

// What the first and the last block do not tell stays 0.
LogEntry LogServer::describe(uint16_t number, uint32_t n_blocks) {
  LogEntry entry = {};
  entry.number = number;
  entry.blocks = n_blocks;
  BlockHeader head;
  if (n_blocks > 0 && head_of(number, n_blocks - 1, head)) {
    entry.closed = head.kind == BlockKind::kFooter ? 1 : 0;
  }
  if (n_blocks > 0 && head_of(number, 0, head)) {
    entry.session = head.session;
    protocol::LogHeader header;
    if (head.kind == BlockKind::kHeader &&
        header.decode(block_.bytes + BlockHeader::kSize, protocol::LogHeader::kSize)) {
      entry.wall_clock_us = header.wall_clock_us;
    }
  }
  return entry;
}

// A whole block of ours: it stays in block_.
bool LogServer::head_of(uint16_t number, uint32_t index, BlockHeader& head) {
  loaded_ = false;
  if (read(number, index) != ErrorCode::kNone) return false;
  protocol::Reader crc(block_.bytes + protocol::kBlockCrcOffset);
  return crc.u32() == protocol::crc32(block_.bytes, protocol::kBlockCrcOffset) &&
         head.decode(block_.bytes, BlockHeader::kSize) && head.magic == protocol::kBlockMagic;
}

ErrorCode LogServer::read(uint16_t number, uint32_t index) {
  if (number != kRam) return archive_.read(number, index, block_.bytes);
  return recorder_.copy_from_ram(index, block_) ? ErrorCode::kNone : ErrorCode::kNoSuchLog;
}

ErrorCode LogServer::check(uint16_t number, uint32_t session, LogEntry& entry) {
  if (!find(number, entry)) return ErrorCode::kNoSuchLog;
  return entry.session == session ? ErrorCode::kNone : ErrorCode::kLogChanged;
}

ErrorCode LogServer::begin_read(const protocol::LogReadRequest& request, uint16_t& count) {
  end();
  LogEntry entry;
  const ErrorCode error = check(request.number, request.session, entry);
  if (error != ErrorCode::kNone) return error;
  if (request.first_block >= entry.blocks) return ErrorCode::kNoSuchLog;
  const uint32_t behind = entry.blocks - request.first_block;
  uint32_t blocks = request.count < behind ? request.count : behind;
  if (blocks > protocol::kLogReadBlocks) blocks = protocol::kLogReadBlocks;
  number_ = request.number;
  block_index_ = request.first_block;
  part_ = 0;
  const ErrorCode unread = read(number_, block_index_);
  if (unread != ErrorCode::kNone) return unread;
  loaded_ = true;
  count = static_cast<uint16_t>(blocks);
  left_ = count;
  return ErrorCode::kNone;
}

ErrorCode LogServer::erase(const protocol::LogEraseRequest& request) {
  end();
  LogEntry entry;
  const ErrorCode error = check(request.number, request.session, entry);
  if (error != ErrorCode::kNone) return error;
  if (request.number != kRam) return archive_.erase(request.number);
  recorder_.release_ram();
  return ErrorCode::kNone;
}

bool LogServer::poll(protocol::Link& link) {
  if (left_ == 0) return false;
  if (!loaded_) {
    if (read(number_, block_index_) != ErrorCode::kNone) {
      end();  // the host asks again, and is told what is wrong
      return false;
    }
    loaded_ = true;
    part_ = 0;
  }
  return part_ == 0 && block_is_zero() ? send_zeros(link) : send_part(link);
}

void LogServer::advance(uint16_t blocks) {
  block_index_ += blocks;
  left_ = static_cast<uint16_t>(left_ - blocks);
  loaded_ = false;
}

bool LogServer::block_is_zero() const {
  for (size_t i = 0; i < sizeof block_.bytes; ++i) {
    if (block_.bytes[i] != 0) return false;
  }
  return true;
}

bool LogServer::send_part(protocol::Link& link) {
  protocol::LogPartStream part;
  part.block = block_index_;
  part.part = part_;
  memcpy(part.data, block_.bytes + part_ * protocol::kLogPartBytes, protocol::kLogPartBytes);
  uint8_t payload[protocol::LogPartStream::kSize];
  part.encode(payload);
  if (!link.send_stream(protocol::LogPartStream::kType, payload, sizeof payload)) return false;
  if (++part_ == kParts) advance(1);
  return true;
}

// A recording that was cut leaves most of its file unused, so zeros go in runs.
bool LogServer::send_zeros(protocol::Link& link) {
  const uint16_t most = left_ < kZeroRun ? left_ : kZeroRun;
  uint16_t count = 1;
  while (count < most && read(number_, block_index_ + count) == ErrorCode::kNone &&
         block_is_zero()) {
    ++count;
  }
  loaded_ = false;
  protocol::LogZerosStream zeros;
  zeros.first_block = block_index_;
  zeros.count = count;
  uint8_t payload[protocol::LogZerosStream::kSize];
  zeros.encode(payload);
  if (!link.send_stream(protocol::LogZerosStream::kType, payload, sizeof payload)) return false;
  advance(count);
  return true;
}

}  // namespace logger
}  // namespace tfsat

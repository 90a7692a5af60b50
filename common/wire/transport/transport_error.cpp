#include "common/wire/transport/transport_error.h"

#include <string>

namespace copresence::wire {
namespace {

class TransportCategory final : public asio::error_category {
 public:
  const char* name() const noexcept override { return "transport"; }
  std::string message(int code) const override {
    switch (static_cast<TransportError>(code)) {
      case TransportError::kPeerIsPlain:
        return "the other end does not encrypt";
      case TransportError::kPeerIsEncrypted:
        return "the other end encrypts";
      case TransportError::kWrongKey:
        return "the other end has another room key";
      case TransportError::kBroken:
        break;
    }
    return "the encrypted stream is damaged";
  }
};

}  // namespace

asio::error_code make_error_code(TransportError error) {
  static const TransportCategory category;
  return {static_cast<int>(error), category};
}

}  // namespace copresence::wire

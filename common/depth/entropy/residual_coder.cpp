#include "common/depth/entropy/residual_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <utility>

#include "common/depth/entropy/adaptive_cdf.h"
#include "common/depth/entropy/ans_coder.h"

namespace copresence::depth {
namespace {

constexpr int kStreams = AnsWriter::kStreams;
constexpr unsigned kEscape = AdaptiveCdf::kSymbols - 1;  // Marks differences without their own symbol.
constexpr int kReach = 2;                                // Contexts clamp differences to at most this.
constexpr int kSteps = 2 * kReach + 1;
constexpr int kContexts = kSteps * kSteps * kSteps * kSteps;
constexpr int kMiddle = 7;               // The symbol for a difference of 0.
constexpr unsigned kMostBits = 11;       // Bits of an escaped difference below its leading bit.
constexpr std::size_t kMostSymbols = 3;  // Symbols per pixel: escape, number of bits, bits.

// Each stream has its own models. With shared models, the streams would wait for each other.
struct Models {
  std::array<AdaptiveCdf, kContexts> difference;
  AdaptiveCdf escaped_bits;
};

int step(int difference) {
  return std::clamp(difference, -kReach, kReach) + kReach;
}

struct Stream {
  Stream(int y_, int end_, std::ptrdiff_t width)
      : y(y_),
        end(end_),
        columns(static_cast<std::size_t>(width) + 1),
        contexts(static_cast<std::size_t>(width)) {}

  int y, end;                           // Rows still to code.
  std::uint16_t* row = nullptr;         // Samples of the current row.
  const std::uint16_t* next = nullptr;  // Columns of the row's pixels still to code, up to row_end.
  const std::uint16_t* row_end = nullptr;
  std::vector<std::uint16_t> columns;   // Columns of the row's pixels that are not holes.
  std::vector<std::uint16_t> contexts;  // Contexts of the row's pixels, without the left neighbour's part.
};

// The raster scan over all samples, shared by encoder and decoder. The first stream codes the upper
// half of the pixels and the second the lower half, alternately. The array of samples has a margin
// of two rows before and after. At the image's left and right borders, the neighbour is a pixel of
// an adjacent row. Encoder and decoder treat borders alike.
template <class Coder>
class Scan {
 public:
  Scan(Coder coder, std::array<Models, kStreams>& models, std::uint16_t* samples, const StateImage& states)
      : coder_(coder), models_(models), samples_(samples), states_(states), width_(states.width()) {}

  void run(const std::array<int, kStreams + 1>& split) {
    std::vector<Stream> streams;
    for (std::size_t i = 0; i < kStreams; ++i) streams.emplace_back(split[i], split[i + 1], width_);
    while (true) {
      std::ptrdiff_t count = width_;
      for (Stream& stream : streams) count = std::min(count, remaining(stream));
      if (count == 0) break;
      interleave(streams.data(), count, std::make_integer_sequence<unsigned, kStreams>());
    }
    for (unsigned i = 0; i < kStreams; ++i) {
      while (remaining(streams[i]) > 0) {
        const unsigned column = *streams[i].next++;
        sample(coder_, i, streams[i].row + column, streams[i].contexts[column]);
      }
    }
  }

  Coder& coder() { return coder_; }

 private:
  // Returns the number of pixels left in a stream's row, after beginning the next row if needed.
  std::ptrdiff_t remaining(Stream& stream) {
    while (stream.next == stream.row_end && stream.y < stream.end) begin_row(stream);
    return stream.row_end - stream.next;
  }

  // Lists the row's pixels and finds their contexts.
  void begin_row(Stream& stream) {
    const int width = static_cast<int>(width_);
    stream.row = samples_ + static_cast<std::ptrdiff_t>(stream.y) * width_;
    const std::uint16_t* const row = stream.row;
    const std::uint16_t* const above = row - width_;
    const DepthState* const state = states_.row(stream.y).data();
    std::uint16_t* const contexts = stream.contexts.data();
    for (int x = 0; x < width; ++x) {
      const int context = (step(above[x + 1] - above[x]) * kSteps + step(above[x - 1] - above[x])) * kSteps +
                          step(row[x] - above[x]);
      contexts[x] = static_cast<std::uint16_t>(kSteps * context);
    }
    std::uint16_t* const columns = stream.columns.data();
    std::size_t count = 0;
    for (int x = 0; x < width; ++x) {
      columns[count] = static_cast<std::uint16_t>(x);
      count += state[x] != DepthState::kHole;
    }
    stream.next = columns;
    stream.row_end = stream.next + count;
    ++stream.y;
  }

  // Codes `count` pixels of each stream, alternately.
  template <unsigned... kStream>
  void interleave(Stream* streams, std::ptrdiff_t count, std::integer_sequence<unsigned, kStream...>) {
    Coder coder = coder_;
    const std::uint16_t* const next[] = {streams[kStream].next...};
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      (sample(coder, kStream, streams[kStream].row + next[kStream][i],
              streams[kStream].contexts[next[kStream][i]]),
       ...);
    }
    ((streams[kStream].next += count), ...);
    coder_ = coder;
  }

  [[gnu::always_inline]] void sample(Coder& coder, unsigned stream, std::uint16_t* here, int context) {
    Models& models = models_[stream];
    const int left = here[-1];
    AdaptiveCdf& model = models.difference[context + step(*(here - width_) - left)];
    int difference = 0;
    if constexpr (!Coder::kReads) difference = *(coder.picture + (here - samples_)) - left;
    unsigned symbol = std::min(static_cast<unsigned>(difference + kMiddle), kEscape);
    symbol = coder.code(stream, model, symbol);
    model.learn(symbol);
    if constexpr (Coder::kReads) difference = static_cast<int>(symbol) - kMiddle;
    if (symbol == kEscape) [[unlikely]]
      difference = escaped(coder, stream, models.escaped_bits, difference);
    *here = static_cast<std::uint16_t>(left + difference);
  }

  // Escape code of a difference beyond the symbols. The number 2 (|difference| - kMiddle) + sign is
  // coded as its bit length and the bits below its leading one.
  int escaped(Coder& coder, unsigned stream, AdaptiveCdf& model, int difference) {
    unsigned number = 0;
    if constexpr (!Coder::kReads)
      number = difference < 0 ? static_cast<unsigned>(-difference - kMiddle) * 2 + 1
                              : static_cast<unsigned>(difference - kMiddle) * 2;
    const unsigned bits =
        std::min(coder.code(stream, model, static_cast<unsigned>(std::bit_width(number) - 1)), kMostBits);
    model.learn(bits);
    number = (1u << bits) + coder.code_bits(stream, number - (1u << bits), static_cast<int>(bits));
    const int size = static_cast<int>(number >> 1) + kMiddle;
    return number % 2 != 0 ? -size : size;
  }

  Coder coder_;
  std::array<Models, kStreams>& models_;
  std::uint16_t* const samples_;
  const StateImage& states_;
  const std::ptrdiff_t width_;
};

struct Writer {
  static constexpr bool kReads = false;
  AnsWriter ans;
  const std::uint16_t* picture;
  unsigned code(unsigned stream, const AdaptiveCdf& model, unsigned symbol) {
    ans.put(stream, model.slot(symbol));
    return symbol;
  }
  unsigned code_bits(unsigned stream, unsigned value, int bits) {
    ans.put_bits(stream, value, bits);
    return value;
  }
};

struct Reader {
  static constexpr bool kReads = true;
  AnsReader ans;
  unsigned code(unsigned stream, const AdaptiveCdf& model, unsigned) { return ans.get(stream, model); }
  unsigned code_bits(unsigned stream, unsigned, int bits) { return ans.get_bits(stream, bits); }
};

}  // namespace

struct ResidualMemory {
  ResidualMemory(PixelFormat format_, int width_, int height_)
      : format(format_),
        width(width_),
        height(height_),
        stored(static_cast<std::size_t>(width) * (height + 4)),
        models(std::make_unique<std::array<Models, kStreams>>()) {}

  std::uint16_t* samples() { return stored.data() + 2 * width; }

  void next(bool complete) {
    if (!complete) return;
    std::fill(stored.begin(), stored.end(), std::uint16_t{0});
    models->fill({});
  }

  // Returns the rows at which the streams begin and end. The streams have about equally many
  // pixels.
  std::array<int, kStreams + 1> split(const StateImage& states) const {
    std::vector<std::ptrdiff_t> above(static_cast<std::size_t>(height) + 1);
    for (int y = 0; y < height; ++y) {
      const auto* row = reinterpret_cast<const std::uint8_t*>(states.row(y).data());
      int count = 0;
      for (int x = 0; x < width; ++x) count += row[x] != 0;
      above[y + 1] = above[y] + count;
    }
    std::array<int, kStreams + 1> rows{};
    for (int i = 1; i <= kStreams; ++i) {
      rows[i] = rows[i - 1];
      while (rows[i] < height && above[rows[i]] < above[height] * i / kStreams) ++rows[i];
    }
    rows[kStreams] = height;
    return rows;
  }

  PixelFormat format;
  int width, height;
  std::vector<std::uint16_t> stored;
  std::unique_ptr<std::array<Models, kStreams>> models;
  std::vector<std::uint16_t> widened;        // In the encoder: the 8-bit picture, widened to 16 bits.
  std::unique_ptr<std::uint32_t[]> symbols;  // Used by the encoder.
};

ResidualEncoder::ResidualEncoder(PixelFormat format, int width, int height)
    : memory_(std::make_unique<ResidualMemory>(format, width, height)) {}
ResidualEncoder::~ResidualEncoder() = default;
ResidualEncoder::ResidualEncoder(ResidualEncoder&&) noexcept = default;
ResidualEncoder& ResidualEncoder::operator=(ResidualEncoder&&) noexcept = default;

void ResidualEncoder::encode(const Picture& picture, const StateImage& states, bool complete,
                             std::vector<std::uint8_t>& out) {
  ResidualMemory& memory = *memory_;
  assert(picture.format() == memory.format && picture.width() == memory.width &&
         picture.height() == memory.height);
  memory.next(complete);
  if (!memory.symbols)
    memory.symbols = std::make_unique_for_overwrite<std::uint32_t[]>(kMostSymbols * states.pixels().size());
  const std::uint16_t* source = nullptr;
  if (memory.format == PixelFormat::kGray10) {
    source = picture.plane10().data();
  } else {
    memory.widened.assign(picture.plane8(0).begin(), picture.plane8(0).end());
    source = memory.widened.data();
  }
  Scan scan(Writer{AnsWriter(memory.symbols.get()), source}, *memory.models, memory.samples(), states);
  scan.run(memory.split(states));
  scan.coder().ans.finish(out);
}

ResidualDecoder::ResidualDecoder(PixelFormat format, int width, int height)
    : memory_(std::make_unique<ResidualMemory>(format, width, height)) {}
ResidualDecoder::~ResidualDecoder() = default;
ResidualDecoder::ResidualDecoder(ResidualDecoder&&) noexcept = default;
ResidualDecoder& ResidualDecoder::operator=(ResidualDecoder&&) noexcept = default;

void ResidualDecoder::decode(std::span<const std::uint8_t> bytes, const StateImage& states, bool complete,
                             Picture& picture) {
  ResidualMemory& memory = *memory_;
  memory.next(complete);
  Scan scan(Reader{AnsReader(bytes)}, *memory.models, memory.samples(), states);
  scan.run(memory.split(states));
  if (picture.format() != memory.format || picture.width() != memory.width ||
      picture.height() != memory.height) {
    picture = Picture(memory.format, memory.width, memory.height);
  }
  const std::uint16_t* const samples = memory.samples();
  if (memory.format == PixelFormat::kGray10) {
    std::copy_n(samples, picture.plane10().size(), picture.plane10().data());
  } else {
    std::transform(samples, samples + picture.plane8(0).size(), picture.plane8(0).begin(),
                   [](std::uint16_t sample) { return static_cast<std::uint8_t>(sample); });
  }
}

}  // namespace copresence::depth

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

constexpr int kLanes = AnsWriter::kLanes;
constexpr unsigned kEscape = AdaptiveCdf::kSymbols - 1;  // a difference that no other symbol stands for
constexpr int kReach = 2;  // differences of neighbours are told apart up to here
constexpr int kSteps = 2 * kReach + 1;
constexpr int kContexts = kSteps * kSteps * kSteps * kSteps;
constexpr int kMiddle = 7;               // the symbol of no difference
constexpr unsigned kMostBits = 11;       // of a larger difference, after the first
constexpr std::size_t kMostSymbols = 3;  // for a pixel: escape, bits, those bits

// A lane's own: two lanes that shared them would wait for each other.
struct Models {
  std::array<AdaptiveCdf, kContexts> difference;
  AdaptiveCdf bits_beyond;
};

int step(int difference) {
  return std::clamp(difference, -kReach, kReach) + kReach;
}

// A lane's way through its rows.
struct Lane {
  Lane(int y_, int end_, std::ptrdiff_t width)
      : y(y_),
        end(end_),
        columns(static_cast<std::size_t>(width) + 1),
        contexts(static_cast<std::size_t>(width)) {}

  int y, end;                           // rows still to come
  std::uint16_t* row = nullptr;         // the row's samples
  const std::uint16_t* next = nullptr;  // columns of the pixels in it that are still to come
  const std::uint16_t* row_end = nullptr;
  std::vector<std::uint16_t> columns;   // of the row's pixels that are no holes
  std::vector<std::uint16_t> contexts;  // of all its pixels, as far as the row above says
};

// One walk for both directions, from the left to the right through rows from the top: the first lane takes the upper half of
// the pixels, the second the rest, in turns. Samples stand in an array with two rows of margin before and after; a neighbour beyond
// the image's left or right is one in the next row, which does no harm.
template <class Coder>
class Walk {
 public:
  Walk(Coder coder, std::array<Models, kLanes>& models, std::uint16_t* samples, const StateImage& states)
      : coder_(coder), models_(models), samples_(samples), states_(states), width_(states.width()) {}

  void run(const std::array<int, kLanes + 1>& split) {
    std::vector<Lane> lanes;
    for (std::size_t i = 0; i < kLanes; ++i) lanes.emplace_back(split[i], split[i + 1], width_);
    while (true) {
      std::ptrdiff_t count = width_;
      for (Lane& lane : lanes) count = std::min(count, to_do(lane));
      if (count == 0) break;
      together(lanes.data(), count, std::make_integer_sequence<unsigned, kLanes>());
    }
    for (unsigned i = 0; i < kLanes; ++i) {
      while (to_do(lanes[i]) > 0) {
        const unsigned column = *lanes[i].next++;
        sample(coder_, i, lanes[i].row + column, lanes[i].contexts[column]);
      }
    }
  }

  // As the walk left it.
  Coder& coder() { return coder_; }

 private:
  // Pixels left in a lane's row, or the next; 0 at its end.
  std::ptrdiff_t to_do(Lane& lane) {
    while (lane.next == lane.row_end && lane.y < lane.end) look_ahead(lane);
    return lane.row_end - lane.next;
  }

  void look_ahead(Lane& lane) {
    const int width = static_cast<int>(width_);
    lane.row = samples_ + static_cast<std::ptrdiff_t>(lane.y) * width_;
    const std::uint16_t* const row = lane.row;
    const std::uint16_t* const above = row - width_;
    const DepthState* const state = states_.row(lane.y).data();
    std::uint16_t* const contexts = lane.contexts.data();
    for (int x = 0; x < width; ++x) {
      const int context = (step(above[x + 1] - above[x]) * kSteps + step(above[x - 1] - above[x])) * kSteps +
                          step(row[x] - above[x]);
      contexts[x] = static_cast<std::uint16_t>(kSteps * context);
    }
    std::uint16_t* const columns = lane.columns.data();
    std::size_t count = 0;
    for (int x = 0; x < width; ++x) {
      columns[count] = static_cast<std::uint16_t>(x);
      count += state[x] != DepthState::kHole;
    }
    lane.next = columns;
    lane.row_end = lane.next + count;
    ++lane.y;
  }

  template <unsigned... kLane>
  void together(Lane* lanes, std::ptrdiff_t count, std::integer_sequence<unsigned, kLane...>) {
    Coder coder = coder_;
    const std::uint16_t* const next[] = {lanes[kLane].next...};
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      (sample(coder, kLane, lanes[kLane].row + next[kLane][i], lanes[kLane].contexts[next[kLane][i]]), ...);
    }
    ((lanes[kLane].next += count), ...);
    coder_ = coder;
  }

  [[gnu::always_inline]] void sample(Coder& coder, unsigned lane, std::uint16_t* here, int context) {
    Models& models = models_[lane];
    const int left = here[-1];
    AdaptiveCdf& model = models.difference[context + step(*(here - width_) - left)];
    int difference = 0;
    if constexpr (!Coder::kReads) difference = *(coder.picture + (here - samples_)) - left;
    unsigned symbol = std::min(static_cast<unsigned>(difference + kMiddle), kEscape);
    symbol = coder.code(lane, model, symbol);
    model.learn(symbol);
    if constexpr (Coder::kReads) difference = static_cast<int>(symbol) - kMiddle;
    if (symbol == kEscape) [[unlikely]]
      difference = beyond(coder, lane, models.bits_beyond, difference);
    *here = static_cast<std::uint16_t>(left + difference);
  }

  // A difference of more than kMiddle: how many bits has what it is more by than that, and its sign; then those bits but the first.
  int beyond(Coder& coder, unsigned lane, AdaptiveCdf& model, int difference) {
    unsigned number = 0;
    if constexpr (!Coder::kReads)
      number = difference < 0 ? static_cast<unsigned>(-difference - kMiddle) * 2 + 1
                              : static_cast<unsigned>(difference - kMiddle) * 2;
    const unsigned bits =
        std::min(coder.code(lane, model, static_cast<unsigned>(std::bit_width(number) - 1)), kMostBits);
    model.learn(bits);
    number = (1u << bits) + coder.code_bits(lane, number - (1u << bits), static_cast<int>(bits));
    const int size = static_cast<int>(number >> 1) + kMiddle;
    return number % 2 != 0 ? -size : size;
  }

  Coder coder_;
  std::array<Models, kLanes>& models_;
  std::uint16_t* const samples_;
  const StateImage& states_;
  const std::ptrdiff_t width_;
};

struct Writer {
  static constexpr bool kReads = false;
  AnsWriter ans;
  const std::uint16_t* picture;
  unsigned code(unsigned lane, const AdaptiveCdf& model, unsigned symbol) {
    ans.put(lane, model.slot(symbol));
    return symbol;
  }
  unsigned code_bits(unsigned lane, unsigned value, int bits) {
    ans.put_bits(lane, value, bits);
    return value;
  }
};

struct Reader {
  static constexpr bool kReads = true;
  AnsReader ans;
  unsigned code(unsigned lane, const AdaptiveCdf& model, unsigned) { return ans.get(lane, model); }
  unsigned code_bits(unsigned lane, unsigned, int bits) { return ans.get_bits(lane, bits); }
};

}  // namespace

struct ResidualMemory {
  ResidualMemory(PixelFormat format_, int width_, int height_)
      : format(format_),
        width(width_),
        height(height_),
        stored(static_cast<std::size_t>(width) * (height + 4)),
        models(std::make_unique<std::array<Models, kLanes>>()) {}

  std::uint16_t* samples() { return stored.data() + 2 * width; }

  void next(bool complete) {
    if (!complete) return;
    std::fill(stored.begin(), stored.end(), std::uint16_t{0});
    models->fill({});
  }

  // The rows at which lanes begin, and the last one's end: about as many pixels for each.
  std::array<int, kLanes + 1> split(const StateImage& states) const {
    std::vector<std::ptrdiff_t> above(static_cast<std::size_t>(height) + 1);
    for (int y = 0; y < height; ++y) {
      const auto* row = reinterpret_cast<const std::uint8_t*>(states.row(y).data());
      int count = 0;
      for (int x = 0; x < width; ++x) count += row[x] != 0;
      above[y + 1] = above[y] + count;
    }
    std::array<int, kLanes + 1> rows{};
    for (int lane = 1; lane <= kLanes; ++lane) {
      rows[lane] = rows[lane - 1];
      while (rows[lane] < height && above[rows[lane]] < above[height] * lane / kLanes) ++rows[lane];
    }
    rows[kLanes] = height;
    return rows;
  }

  PixelFormat format;
  int width, height;
  std::vector<std::uint16_t> stored;
  std::unique_ptr<std::array<Models, kLanes>> models;
  std::vector<std::uint16_t> widened;     // of the encoder: an 8-bit picture
  std::unique_ptr<std::uint32_t[]> room;  // of the encoder
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
  if (!memory.room)
    memory.room = std::make_unique_for_overwrite<std::uint32_t[]>(kMostSymbols * states.pixels().size());
  const std::uint16_t* source = nullptr;
  if (memory.format == PixelFormat::kGray10) {
    source = picture.plane10().data();
  } else {
    memory.widened.assign(picture.plane8(0).begin(), picture.plane8(0).end());
    source = memory.widened.data();
  }
  Walk walk(Writer{AnsWriter(memory.room.get()), source}, *memory.models, memory.samples(), states);
  walk.run(memory.split(states));
  walk.coder().ans.finish(out);
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
  Walk walk(Reader{AnsReader(bytes)}, *memory.models, memory.samples(), states);
  walk.run(memory.split(states));
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

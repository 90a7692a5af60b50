#include "common/bitstream/blank_picture.h"

#include <bit>
#include <cassert>
#include <span>

#include "common/bitstream/access_unit.h"

namespace copresence::bitstream {
namespace {

constexpr std::uint8_t kImportant = 0x60;  // The value of `nal_ref_idc` is 3.
constexpr int kMacroblock = 16;            // Pixels per side.
constexpr unsigned kFrameNumbers = 16;     // The value of `log2_max_frame_num_minus4` is 0.
constexpr unsigned kHigh10Profile = 110;
constexpr unsigned kLevel = 51;  // Level 5.1: up to 4096x2304 at 26 pictures a second.

/// Writes the bits of one NAL unit with the codes of H.264, sections 7.2 and 9.1.
class Bits {
 public:
  explicit Bits(NalType type) { fixed(kImportant | static_cast<unsigned>(type), 8); }

  void fixed(unsigned value, int bits) {
    for (int i = bits - 1; i >= 0; --i) bit(value >> i & 1);
  }
  void flag(bool value) { bit(value); }
  void number(unsigned value) {  // The code ue(v).
    const int bits = static_cast<int>(std::bit_width(value + 1));
    fixed(0, bits - 1);
    fixed(value + 1, bits);
  }
  void zero() { number(0); }  // The codes ue(v) and se(v) are equal for 0.

  void finish(std::vector<std::uint8_t>& access_unit) {
    bit(1);
    while (used_ != 0) bit(0);
    append_nal(access_unit, to_nal_bytes(bytes_));
  }

 private:
  void bit(unsigned value) {
    if (used_ == 0) bytes_.push_back(0);
    bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | value << (7 - used_));
    used_ = (used_ + 1) % 8;
  }

  std::vector<std::uint8_t> bytes_;
  int used_ = 0;  // Number of bits used in the last byte.
};

unsigned macroblocks(int pixels) {
  return static_cast<unsigned>((pixels + kMacroblock - 1) / kMacroblock);
}

}  // namespace

BlankPictureWriter::BlankPictureWriter(PixelFormat format, int width, int height)
    : format_(format), width_(width), height_(height) {
  assert(format == PixelFormat::kGray8 || format == PixelFormat::kGray10);
}

std::vector<std::uint8_t> BlankPictureWriter::sequence_parameters() const {
  const unsigned deeper = format_ == PixelFormat::kGray10 ? 2 : 0;  // Number of bits per sample beyond 8.
  Bits bits(NalType::kSequenceParameters);
  bits.fixed(kHigh10Profile, 8);
  bits.fixed(0, 8);  // No constraints.
  bits.fixed(kLevel, 8);
  bits.zero();  // `seq_parameter_set_id`.
  bits.zero();  // `chroma_format_idc`: monochrome.
  bits.number(deeper);
  bits.number(deeper);  // The same for chroma.
  bits.fixed(0, 2);     // No transform bypass, no scaling matrices.
  bits.zero();          // `log2_max_frame_num_minus4`.
  bits.number(2);       // `pic_order_cnt_type`: output in order.
  bits.number(1);       // `max_num_ref_frames`.
  bits.flag(false);     // No gaps in `frame_num`.
  bits.number(macroblocks(width_) - 1);
  bits.number(macroblocks(height_) - 1);
  bits.flag(true);  // `frame_mbs_only_flag`.
  bits.flag(true);  // `direct_8x8_inference_flag`.
  const unsigned right = macroblocks(width_) * kMacroblock - static_cast<unsigned>(width_);
  const unsigned bottom = macroblocks(height_) * kMacroblock - static_cast<unsigned>(height_);
  bits.flag(right != 0 || bottom != 0);  // `frame_cropping_flag`.
  if (right != 0 || bottom != 0) {
    bits.zero();
    bits.number(right);
    bits.zero();
    bits.number(bottom);
  }
  bits.flag(false);  // No VUI.
  std::vector<std::uint8_t> unit;
  bits.finish(unit);

  Bits picture(NalType::kPictureParameters);
  picture.zero();       // `pic_parameter_set_id`.
  picture.zero();       // `seq_parameter_set_id`.
  picture.fixed(0, 2);  // CAVLC, no field order.
  picture.zero();       // One slice group.
  picture.zero();       // One reference picture, also for list 1.
  picture.zero();
  picture.fixed(0, 3);  // No weighted prediction.
  picture.zero();       // `pic_init_qp_minus26`.
  picture.zero();       // `pic_init_qs_minus26`.
  picture.zero();       // `chroma_qp_index_offset`.
  picture.fixed(4, 3);  // Slices control deblocking; no constrained intra, no redundant pictures.
  picture.finish(unit);
  return unit;
}

std::vector<std::uint8_t> BlankPictureWriter::write(bool keyframe) {
  std::vector<std::uint8_t> unit;
  if (keyframe) {
    unit = sequence_parameters();
    frame_number_ = 0;
    ++keyframes_;
  }
  const unsigned count = macroblocks(width_) * macroblocks(height_);
  Bits slice(keyframe ? NalType::kIdrSlice : NalType::kSlice);
  slice.zero();                    // `first_mb_in_slice`.
  slice.number(keyframe ? 7 : 5);  // `slice_type`: all I or all P.
  slice.zero();                    // `pic_parameter_set_id`.
  slice.fixed(frame_number_ % kFrameNumbers, 4);
  if (keyframe) {
    slice.number(keyframes_ % 2);  // `idr_pic_id` differs from that of the keyframe before.
    slice.fixed(0, 2);             // `dec_ref_pic_marking`.
  } else {
    slice.fixed(0, 3);  // No reference list changes, no marking.
  }
  slice.zero();     // `slice_qp_delta`.
  slice.number(1);  // No deblocking.
  if (keyframe) {
    for (unsigned i = 0; i < count; ++i) {
      slice.number(3);   // I_16x16_2_0_0 predicts the mean of the neighbours, or mid grey.
      slice.zero();      // `mb_qp_delta`.
      slice.flag(true);  // `coeff_token`: no coefficients.
    }
  } else {
    slice.number(count);  // `mb_skip_run`.
  }
  slice.finish(unit);
  ++frame_number_;
  return unit;
}

}  // namespace copresence::bitstream

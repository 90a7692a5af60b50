#pragma once

// Rules by which both renderers fill the pixels of a view that no camera has seen. The farther
// surfaces around a hole are extended behind the object that hides them.
//
// The rules use the inverse depth w = 1/z (1/m, z along the eye's axis). A plane's w is an affine
// function of the pixel. The view is divided into blocks of kExtensionBlock pixels a side.
//
// Block     The surface of a block is the mean w and colour of its farthest pixels, those within
//           kOwnSurface of the smallest w. A block with at least one empty pixel is a gap.
// Source    From a gap, a search in each of eight directions ends at the first block without empty
//           pixels. The colour of this edge block may be mixed with that of a nearer surface. So
//           the next block behind it becomes the source if both lie on the same surface.
// Opposite  The w of two opposite sources is extrapolated to the gap, each along its own slope. If
//           both results agree within kSameSurface, w and colour are interpolated linearly between
//           the sources. Otherwise only the farther source is used. Its w follows its slope, but
//           changes by at most the fraction kMostChange. It never exceeds the w of the nearer
//           source, so that an unseen surface never covers a seen one.
// Estimate  The four pairs of directions and the block's own surface give up to five estimates.
//           Those within kSameSurface of the farthest are averaged; near sources have more weight.
//           Then kSmoothingRounds of averaging with neighbours on the same surface remove streaks.
// Fading    Outside all cameras' pictures, estimates fade to the background colour over the
//           fraction kFadeShare of a picture's width. Depth beyond kFarthestM becomes kFarthestM.
// Colour    A camera's picture may show an extended surface although it has no depth there. The
//           surface then gets the colour from the first such camera in the list that has colour. A
//           pixel of the camera sees the surface if its w exceeds that of the surface by at most
//           kOwnSurface. Here, w is along the camera's axis, and 0 for a pixel without depth. A
//           pixel that is left out (merge_rules.h) sees no extended surface. At depth edges, the
//           colours of both sides mix. So the four pixels at the distance kMixedColors in the same
//           row and column are examined first. The position moves by kMixedColors away from those
//           that do not see the surface. If none of the four sees it, the camera is not used. The
//           colour is the bilinear mean of the pixels that see the
//           surface. Their weights must sum to at least kLeastVisibleShare.
// Pixel     An empty pixel is interpolated between the four nearest blocks. Only blocks on the
//           farthest of their surfaces are used.
//
// Thread: constants.

namespace copresence::renderer {

inline constexpr int kExtensionBlock = 8;      ///< Pixels.
inline constexpr float kSameSurface = 0.045F;  ///< In 1/m; 16 disparity steps of a Kinect v1.
inline constexpr float kOwnSurface = 0.0228F;  ///< In 1/m; 8 disparity steps of a Kinect v1.
inline constexpr float kMostSlope = 0.02F;     ///< In 1/m per block. Depth edges are steeper.
inline constexpr float kMostChange = 0.07F;    ///< Fraction of w.
inline constexpr float kFarthestM = 10;
inline constexpr int kSmoothingRounds = 6;
inline constexpr float kFadeShare = 0.06F;
/// Weight of the block's own surface. A source that is d blocks away has the weight 1 / (1 + d).
inline constexpr float kOwnWeight = 2;
inline constexpr int kMixedColors = 2;  ///< Pixels.
inline constexpr float kLeastVisibleShare = 0.02F;

}  // namespace copresence::renderer

#pragma once

// How the view goes on where no camera has seen anything: the farther surfaces around a hole are continued behind what
// hides them. Both renderers follow these rules.
//
// The rules work on inverse depth w = 1/z (1/m, along the eye's axis), in which planes are affine, and on blocks of
// kExtensionBlock pixels a side.
//
// Block     A block's surface is the farthest of its pixels: the mean w and colour of those within kSameSurface of the
//           smallest w. A block with at least one empty pixel is a gap.
// Source    From a gap, each of eight directions leads to the first block that is no gap. Its colour may carry that of
//           the surface before it, so the block behind it is the source if it lies on the same surface.
// Opposite  The sources of opposite directions lie on one surface if w, continued from both with the slope that they
//           have there, agrees to kSameSurface. Then w and colour between them are linear. Else the farther source
//           counts alone. Its slope is followed, but w changes by kMostChange of itself at most, and never becomes
//           larger than at the nearer source: nothing unseen may cover what is seen.
// Estimate  Of these four estimates and the block's own surface, those within kSameSurface of the farthest are averaged,
//           near sources more than far ones. kSmoothingRounds of averaging with neighbours on the same surface remove
//           streaks.
// Fading    Estimates outside all cameras' pictures fade to the background colour over kFadeShare of a picture's width,
//           so that the view ends without torn edges. Depth beyond kFarthestM counts as kFarthestM.
// Pixel     An empty pixel is interpolated between the four nearest blocks that lie on the farthest of their surfaces.
//
// Thread: constants.

namespace copresence::renderer {

inline constexpr int kExtensionBlock = 8;      ///< pixels
inline constexpr float kSameSurface = 0.045F;  ///< 1/m; 16 disparity steps of a Kinect v1
inline constexpr float kOwnSurface = 0.0228F;  ///< 1/m; within one block: 8 such steps
inline constexpr float kMostSlope = 0.02F;     ///< 1/m per block; steeper ones are depth edges
inline constexpr float kMostChange = 0.07F;    ///< share of w
inline constexpr float kFarthestM = 10;
inline constexpr int kSmoothingRounds = 6;
inline constexpr float kFadeShare = 0.06F;
inline constexpr float kOwnWeight = 2;  ///< of the block's own surface, beside 1 for a source next to it

}  // namespace copresence::renderer

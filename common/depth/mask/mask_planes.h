#pragma once

// States as two bit planes.
//
// Thread: a value.

#include "common/depth/mask/bit_plane.h"
#include "common/frame/image.h"

namespace copresence::depth {

/// A hole is in neither.
struct MaskPlanes {
  BitPlane measured, filled;
  void clear() { measured.clear(), filled.clear(); }
};

/// Requires planes of the states' shape. Returns whether any pixel is filled.
bool pack(const StateImage& states, MaskPlanes& planes);

/// Requires planes of the states' shape.
void unpack(const MaskPlanes& planes, StateImage& states);

}  // namespace copresence::depth

// The constants of merge_rules.h and extension_rules.h, for the page's shaders.

#include "render_client/renderer/extension_rules.h"
#include "render_client/renderer/merge_rules.h"
#include "web/native/exports.h"

namespace copresence::web {

COPRESENCE_EXPORT(merge_rules) int merge_rules() {
  using namespace renderer;
  return succeed(JsonObject()
                     .add("TIE_RATIO", kTieRatio)
                     .add("SILHOUETTE_SHARE", 1.0 / kSilhouetteDivisor)
                     .add("SILHOUETTE_STEPS", kSilhouetteSteps)
                     .add("BLOCK", double(kExtensionBlock))
                     .add("SAME_SURFACE", kSameSurface)
                     .add("OWN_SURFACE", kOwnSurface)
                     .add("MOST_SLOPE", kMostSlope)
                     .add("MOST_CHANGE", kMostChange)
                     .add("FARTHEST_M", double(kFarthestM))
                     .add("OWN_WEIGHT", double(kOwnWeight))
                     .add("SMOOTHING_ROUNDS", double(kSmoothingRounds))
                     .add("FADE_SHARE", kFadeShare)
                     .add("MIXED_COLORS", double(kMixedColors))
                     .add("LEAST_VISIBLE_SHARE", kLeastVisibleShare));
}

}  // namespace copresence::web

// `ransac` (Fischler & Bolles 1981): the textbook, on all nearest neighbours. Uniform samples until
// k = log(1 - p) / log(1 - w^n) from the best inlier ratio w; every hypothesis is verified on all matches.
#include "methods/ransac_method.h"

namespace gms_ransac {

const MethodEntry kRansac = {"ransac", "Fischler & Bolles 1981", "uniform samples from all nearest neighbours", false,
                             &make<UnfilteredMethod>};

}  // namespace gms_ransac

#include "cpplus/core/version.h"

namespace cpplus {

const char* version() { return CPPLUS_VERSION; }

}  // namespace cpplus

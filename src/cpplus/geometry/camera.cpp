#include "cpplus/geometry/camera.h"

#pragma once

// OpenNI2's driver interface. Its header needs two macros from a library that Debian does not ship.

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(object) delete (object)
#include <Driver/OniDriverAPI.h>

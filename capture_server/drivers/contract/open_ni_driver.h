#pragma once

// OpenNI2's driver interface. Its header leaves two macros to a library that Debian does not ship; they stand here once.

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(object) delete (object)
#include <Driver/OniDriverAPI.h>

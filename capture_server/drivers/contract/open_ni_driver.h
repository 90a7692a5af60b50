#pragma once

// Includes OpenNI2's driver interface. That header needs two macros of a library that Debian lacks.

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(object) delete (object)
#include <Driver/OniDriverAPI.h>

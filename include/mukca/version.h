/* The version of the program and of the library. */
#ifndef MUKCA_VERSION_H
#define MUKCA_VERSION_H

#ifdef __cplusplus
extern "C" {
#endif

#define MUKCA_VERSION_MAJOR 0
#define MUKCA_VERSION_MINOR 1
#define MUKCA_VERSION_PATCH 0
#define MUKCA_VERSION "0.1.0"

/* The version of the library that is linked, as MUKCA_VERSION. */
const char *mukca_version(void);

#ifdef __cplusplus
}
#endif
#endif

/* The version of the program and of the library. */
#ifndef MUKCA_VERSION_H
#define MUKCA_VERSION_H

#define MUKCA_VERSION "0.1.0"

#endif

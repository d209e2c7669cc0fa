/* Hashes that identify the model of an arm. */
#ifndef MUKCA_MODEL_CHAIN_HASH_H
#define MUKCA_MODEL_CHAIN_HASH_H

#include "mukca/chain.h"

/* Continue `hash` with numbers, rounded to multiples of `unit`: equal files from other tools differ
 * in the last digit. */
uint64_t mukca_hash_numbers(uint64_t hash, const double *x, int n, double unit);

/* Hash of the nominal origins and axes up to the last joint, to a micrometre and a microradian. */
uint64_t mukca_chain_hash(const mukca_chain *chain);

#endif

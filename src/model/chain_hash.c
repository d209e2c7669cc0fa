/* Hashes that identify the model of an arm. */
#include "model/chain_hash.h"

#include "base/hash.h"

uint64_t mukca_hash_numbers(uint64_t hash, const double *x, int n, double unit)
{
    for (int i = 0; i < n; i++) {
        const int64_t rounded = (int64_t)round(fmin(fmax(x[i] / unit, -1e15), 1e15));
        hash = mukca_hash(hash, &rounded, sizeof rounded);
    }
    return hash;
}

uint64_t mukca_chain_hash(const mukca_chain *chain)
{
    uint64_t hash = MUKCA_HASH_START;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, chain, NULL);
    for (int k = 0; k <= chain->joint_element[chain->n_joints - 1]; k++) {
        hash = mukca_hash_numbers(hash, nominal.origin[k].R, 9, 1e-6);
        hash = mukca_hash_numbers(hash, nominal.origin[k].p, 3, 1e-6);
        if (chain->element[k].joint >= 0)
            hash = mukca_hash_numbers(hash, chain->element[k].axis, 3, 1e-6);
    }
    return hash;
}

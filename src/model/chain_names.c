/* Look-ups in a chain by name. */
#include <string.h>

#include "mukca/chain.h"

int mukca_chain_find_element(const mukca_chain *chain, const char *name)
{
    for (int k = 0; k < chain->n_elements; k++)
        if (!strcmp(chain->element[k].name, name)) return k;
    return -1;
}

const char *mukca_chain_joint_name(const mukca_chain *chain, int joint)
{
    return joint < 0 ? NULL : chain->element[chain->joint_element[joint]].name;
}

int mukca_chain_find_joint(const mukca_chain *chain, const char *name)
{
    const int k = mukca_chain_find_element(chain, name);
    return k < 0 ? -1 : chain->element[k].joint;
}

/* Free and frozen parameters: the default set, packing. */
#include "fit/parameters.h"

#include <string.h>

int mukca_chain_tip_element(const mukca_chain *chain)
{
    const int last = chain->n_elements - 1;
    return last >= 0 && chain->element[last].type == MUKCA_FIXED ? last : -1;
}

bool mukca_element_is_frame(const mukca_element *element)
{
    return element->type == MUKCA_FIXED &&
           (!strcmp(element->name, MUKCA_BASE_FRAME) || !strcmp(element->name, MUKCA_TOOL_FRAME));
}

bool mukca_parameters_standard(const mukca_chain *chain, int k)
{
    const mukca_element *element = &chain->element[k];
    return element->type != MUKCA_FIXED || k == mukca_chain_tip_element(chain) ||
           mukca_element_is_frame(element);
}

void mukca_parameters_set(mukca_parameters *parameters, const mukca_chain *chain,
                          const unsigned char *mark, bool regularise_tip)
{
    const int tip = mukca_chain_tip_element(chain);
    parameters->n = 0;
    for (int i = 0; i < MUKCA_PARAMETERS * chain->n_elements; i++) {
        const int k = i / MUKCA_PARAMETERS;
        if (mark ? !mark[i] : !mukca_parameters_standard(chain, k)) continue;
        parameters->index[parameters->n] = (short)i;
        parameters->regularised[parameters->n++] =
            !mukca_element_is_frame(&chain->element[k]) && (k != tip || regularise_tip);
    }
}

void mukca_parameters_pack(double *x, const mukca_parameters *parameters, const double *theta)
{
    for (int i = 0; i < parameters->n; i++) x[i] = theta[parameters->index[i]];
}

void mukca_parameters_unpack(double *theta, const mukca_parameters *parameters, const double *x)
{
    for (int i = 0; i < parameters->n; i++) theta[parameters->index[i]] = x[i];
}

/* The user's lists of free and frozen parameters. */
#include "fit/fit.h"

#include <string.h>

static int find_parameter(const char *name)
{
    for (int i = 0; i < MUKCA_PARAMETERS; i++)
        if (!strcmp(mukca_parameter_name[i], name)) return i;
    return -1;
}

/* Mark the parameters of one item of a list. */
static mukca_status mark_item(unsigned char *mark, const mukca_chain *chain, const char *item,
                              unsigned char value, mukca_error *error)
{
    char joint[512];
    int element = mukca_chain_find_element(chain, item), parameter = -1;
    if (element < 0 && (parameter = find_parameter(item)) >= 0) {
        for (int k = 0; k < chain->n_elements; k++)
            if (mukca_parameters_standard(chain, k)) mark[MUKCA_PARAMETERS * k + parameter] = value;
        return MUKCA_OK;
    }
    const char *dot = strrchr(item, '.');
    if (element < 0 && dot && (size_t)(dot - item) < sizeof joint) {
        memcpy(joint, item, (size_t)(dot - item));
        joint[dot - item] = '\0';
        element = mukca_chain_find_element(chain, joint);
        parameter = find_parameter(dot + 1);
        if (element >= 0 && parameter < 0)
            return mukca_fail(
                error, MUKCA_USAGE,
                "parameter list: '%.40s' of joint %.64s is not one of x y z roll pitch yaw",
                dot + 1, joint);
    }
    if (element < 0)
        return mukca_fail(
            error, MUKCA_USAGE,
            "parameter list: '%.64s' is neither a joint between %.64s and %.64s nor a "
            "parameter; write joint, parameter or joint.parameter",
            item, chain->base, chain->tip);
    for (int i = 0; i < MUKCA_PARAMETERS; i++)
        if (parameter < 0 || i == parameter) mark[MUKCA_PARAMETERS * element + i] = value;
    return MUKCA_OK;
}

static mukca_status mark_list(unsigned char *mark, const mukca_chain *chain, const char *list,
                              unsigned char value, mukca_error *error)
{
    char item[512];
    while (list) {
        const char *comma = strchr(list, ',');
        const size_t length = comma ? (size_t)(comma - list) : strlen(list);
        if (length == 0 || length >= sizeof item)
            return mukca_fail(error, MUKCA_USAGE,
                              "parameter list: an empty or overlong item; write "
                              "joint, parameter or joint.parameter, with commas");
        memcpy(item, list, length);
        item[length] = '\0';
        mukca_status status = mark_item(mark, chain, item, value, error);
        if (status != MUKCA_OK) return status;
        list = comma ? comma + 1 : NULL;
    }
    return MUKCA_OK;
}

mukca_status mukca_parameters_select(mukca_parameters *parameters, const mukca_chain *chain,
                                     const mukca_selection *selection, mukca_error *error)
{
    unsigned char mark[MUKCA_MAX_FREE] = {0};
    const char *list = selection->free;
    const bool adds = list && list[0] == '+';
    for (int k = 0; k < chain->n_elements; k++)
        if (mukca_parameters_standard(chain, k) &&
            (!list || adds || mukca_element_is_frame(&chain->element[k])))
            memset(mark + MUKCA_PARAMETERS * k, 1, MUKCA_PARAMETERS);
    mukca_status status = MUKCA_OK;
    if (list) status = mark_list(mark, chain, list + adds, 1, error);
    if (status == MUKCA_OK && selection->freeze)
        status = mark_list(mark, chain, selection->freeze, 0, error);
    if (status != MUKCA_OK) return status;
    mukca_parameters_set(parameters, chain, mark, selection->regularise_tip);
    if (parameters->n == 0)
        return mukca_fail(error, MUKCA_USAGE,
                          "no parameter is free: --freeze leaves nothing to fit");
    return MUKCA_OK;
}

/* A URDF that is hard to patch, its chain, and the notes that come. */
#ifndef MUKCA_TESTS_ODD_URDF_H
#define MUKCA_TESTS_ODD_URDF_H

#include "io/urdf.h"
#include "math/random.h"
#include "scratch.h"

static mukca_chain chain;

/* Odd on purpose: CR LF, single quotes, comments that look like joints, a joint without origin, a
 * transmission that names one, attributes in another order, a tab inside. */
static const char urdf[] =
    "<?xml version='1.0'?>\r\n<!-- <joint name='a'><origin xyz='9 9 9'/></joint> -->\r\n"
    "<robot name='odd &amp; arm'>\r\n"
    "<link name='base'/><link name='l1'/><link name='l2'/><link name='ball'/><link "
    "name='side'/>\r\n"
    "<joint  type='revolute'  name='a' >\r\n\t<origin rpy='0 1.5 0'\txyz = '0.1 -0.2 0.3' "
    "></origin>"
    "<parent link='base'/><child link='l1'/><limit lower='-3' upper='3' effort='1' velocity='1'/>"
    "</joint>\r\n"
    "<joint name='b' type='continuous'>\r\n    <parent link='l1'/><child link='l2'/>"
    "<axis xyz='0 1 0'/></joint>\r\n"
    "<joint name=\"t\" type=\"fixed\"><origin xyz=\"0 0 0.5\" />"
    "<parent link=\"l2\"/><child link=\"ball\"/></joint>\r\n"
    "<joint name='s' type='fixed'><origin xyz='0 0 1'/><parent link='l2'/><child "
    "link='side'/></joint>\r\n"
    "<transmission name='x'><joint name='a'><origin xyz='7 7 7'/></joint></transmission>\r\n"
    "</robot>\r\n<!-- the end, no newline -->";

static const char *urdf_path(void)
{
    return scratch_file("odd.urdf", urdf);
}

#endif

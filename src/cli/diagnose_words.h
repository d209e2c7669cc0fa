/* How a diagnosis names and measures causes for people. */
#ifndef MUKCA_CLI_DIAGNOSE_WORDS_H
#define MUKCA_CLI_DIAGNOSE_WORDS_H

#include "cli/diagnose.h"

enum { CLI_WORDS = 320 };

/* Name of a joint of the chain; "" for -1. */
const char *cli_joint_name(const mukca_chain *chain, int joint);

/* Does it move along its axis rather than about it?  False for -1. */
bool cli_joint_slides(const mukca_chain *chain, int joint);

/* SI unit of an effect's size there: "rad", or "m" where the joint slides. */
const char *cli_effect_unit(mukca_effect_kind kind, const mukca_chain *chain, int joint);

/* "joint_compliance at panda_joint2", "base_compliance". */
void cli_effect_words(char text[CLI_WORDS], mukca_effect_kind kind, const mukca_chain *chain,
                      int joint);

/* The same of a cause, with what tells it from others of its kind: ", 240 per turn". */
void cli_cause_words(char text[CLI_WORDS], const mukca_cause *cause, const mukca_chain *chain,
                     const mukca_dataset *data);

/* Size of a cause with its interval in the unit that a mechanic knows: "44.6 [37.4, 51.8]
 * urad/(N*m), 22 kN*m/rad". */
void cli_cause_size(char text[CLI_WORDS], const mukca_cause *cause, const mukca_chain *chain);

/* An angle, rad, as arc minutes: "1.9 arcmin". */
#define CLI_ARCMIN 3437.7467707849396

#endif

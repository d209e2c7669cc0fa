/* From a posterior over sets of causes to findings: the sharpest groups of causes that are sure.
 *
 * One signal often has several possible causes: none of them is sure, while it is certain that one
 * of them is present.  A finding is a group of causes that has a meaning: one effect at one
 * position, over a stretch of positions, all that vary with the same thing, or all at a position.
 * Of all such groups that are sure, disjoint ones as fine as possible are chosen (A. Spector,
 * L. Janson, Controlled discovery and localization of signals via Bayesian linear programming,
 * Journal of the American Statistical Association, 2024: the sum of P / coarseness, by a greedy
 * choice, each group without the causes of finer ones, and then larger than they are).  A group
 * must also have support in halves of the data (R. Shah, R. Samworth, Variable selection with error
 * control, Journal of the Royal Statistical Society B 75, 2013). */
#ifndef MUKCA_INFER_FINDINGS_H
#define MUKCA_INFER_FINDINGS_H

#include <stdbool.h>

#include "base/pool.h"

/* ---- all constants of the decision ---- */

/* Least posterior probability of a finding, of one that names an effect (or says what one varies
 * with that has the probability of a finding), and of a group that may be one.  A wrong name is
 * worse than none, and a coarser statement remains: one in a hundred.  No posterior knows the
 * effects that nobody has thought of. */
#define MUKCA_FINDING_SURE 0.95
#define MUKCA_FINDING_NAMED 0.99
#define MUKCA_FINDING_MAYBE 0.5
/* Share of the halves in its favour, of those that decide, that must be exceeded: in stability
 * selection 0.6 to 0.9 (N. Meinshausen, P. Bühlmann, Journal of the Royal Statistical Society B 72,
 * 2010). */
#define MUKCA_FINDING_STABLE 0.8
/* Least square that a group explains, in units of the noise.  Noise alone yields one per
 * coefficient; 12 is exceeded by 6 coefficients of noise in 6 % of cases, of which the posterior
 * has discounted most.  That something elastic exists is certain; a finding is that it shows. */
#define MUKCA_FINDING_SQUARE 12.0

enum { MUKCA_MOST_FINDINGS = 64, MUKCA_HALVES = 8 };

/* What a possible cause says.  Causes with the same label are one. */
typedef struct {
    int family;   /* what it varies with */
    int effect;   /* of the catalogue; negative: outside it, kinds are counted together */
    int from, to; /* positions along the chain, or apart from it */
    int detail;   /* order or placement; 0: none */
    int tie;      /* declared: causes with the same number may imitate each other; 0: none */
    int blur;     /* details that differ by at most this are the same to the data */
    bool fine;    /* too fine a function to be a part of a cause outside the catalogue */
    bool apart;   /* its positions are not on the chain */
} mukca_label;

typedef struct {
    double weight; /* posterior probability */
    int n;
    const unsigned short *label; /* [n] indices */
    const double *product;       /* [n][n] of the members' displacements, in units of the noise */
} mukca_labelled_set;

typedef struct {
    int n_labels, n_sets;
    const mukca_label *label;
    const mukca_labelled_set *set;
    double least;  /* square that a group explains in these data, at least */
    bool separate; /* causes at disjoint positions show in different data, but for those of a tie */
} mukca_labelled_sets;

typedef enum {
    MUKCA_GROUP_DETAIL, /* an effect at a position, with its order or placement */
    MUKCA_GROUP_EFFECT, /* an effect at a position or over a stretch */
    MUKCA_GROUP_FAMILY, /* all that vary with the same thing there */
    MUKCA_GROUP_TIE,    /* all of a declared tie there, and those apart from the chain */
    MUKCA_GROUP_PLACE   /* anything there */
} mukca_group_kind;

typedef struct mukca_finding_group {
    mukca_group_kind kind;
    int family, effect; /* -1: any */
    int tie;            /* of a tie */
    int from, to;
    int low, high; /* details */
    bool fine, apart;
    double probability; /* posterior; of what is no finding, averaged with that in halves */
    int n_halves;       /* of the data, that were searched */
    double halves;      /* mean probability in these; NaN: none */
    double against;     /* mean probability there that a rival is present instead */
    const struct mukca_finding_group *finer; /* [n_finer] chosen before: their causes are theirs */
    int n_finer;                             /* 0: none of its causes is */
    bool beside_unknown; /* a larger finding is mostly outside the catalogue, of whose cause this
                            may be what no function follows */
} mukca_finding_group;

/* Index of a label among those of label[*n], to which it is appended if it is new. */
int mukca_label_number(mukca_label *labels, int *n, const mukca_label *label);

/* The group of an effect at its place, with its detail. */
mukca_finding_group mukca_finding_alone(const mukca_label *label);

/* Does a group contain causes with this label? */
bool mukca_finding_holds(const mukca_finding_group *group, const mukca_label *label);

/* 95 % interval of the details of a group by the probabilities of the labels, [n_labels]; unchanged
 * if none has a probability. */
void mukca_finding_details(int range[2], const mukca_finding_group *group,
                           const mukca_labelled_sets *posterior, const double *probability);

/* Add the weights of the sets with each label to probability[n_labels]. */
void mukca_labels_weigh(double *probability, const mukca_labelled_sets *posterior);

/* Probability that causes of the group are present and together explain at least `least`; of an
 * effect, that they are no part of a cause outside the catalogue. */
double mukca_finding_probability(const mukca_finding_group *group,
                                 const mukca_labelled_sets *posterior);

/* Share of the group in what all causes explain, and the probability that it has members in a set.
 * The cross products with other causes are split evenly, so that shares of disjoint groups add up.
 */
double mukca_finding_share(const mukca_finding_group *group, const mukca_labelled_sets *posterior);

/* Choose the findings, then, of the remaining causes, those that may be present; halves[n_halves]
 * are posteriors of parts of the data with the same labels.  Groups refer to those before them:
 * `out` must live as long as they do.  Scratch comes from `pool`.  Returns
 * their number, at most MUKCA_MOST_FINDINGS each; *n_findings of these are findings.  -1: no
 * memory. */
int mukca_findings_choose(mukca_finding_group out[2 * MUKCA_MOST_FINDINGS], int *n_findings,
                          mukca_pool *pool, const mukca_labelled_sets *posterior,
                          const mukca_labelled_sets *halves, int n_halves);

#endif

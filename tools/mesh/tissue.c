/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "tissue.h"

#include <string.h>

/* Nearly incompressible: a ratio above 0.49 is what is measured, and 0.45 what linear tetrahedra
 * stand without locking. In a press it stands for 5 % of the force. */
const double tissue_poisson_ratio = 0.45;
/* Not of the literature, whose loss moduli go with a frequency: what stops ringing in a tenth of a
 * second, as in the bundled scenes. */
const double tissue_damping = 30.0;

/* A shear modulus G of elastography counts as E = 3 G. tissue_print has room for names of 9
 * letters. */
static const tissue table[] = {
    {"brain", 1600, 1040, 0, "Budday et al. 2015 (indentation: grey 1.4 kPa, white matter 1.9 kPa)",
     ""},
    {"breast", 3240, 1020, 0, "Samani et al. 2007 (fibroglandular, 3.24 kPa)", ""},
    {"fat", 3250, 950, 4100, "Samani et al. 2007 (of the breast, 3.25 kPa)",
     "Comley and Fleck 2010 (pig, tear test)"},
    {"gelatine", 12500, 1010, 0, "Nguyen et al. 2014 (5 %, G 4.2 kPa)", ""},
    {"heart", 18000, 1060, 0, "Berry et al. 2006 (rat, indentation at rest, 18 kPa)", ""},
    {"kidney", 14700, 1050, 0, "Rouviere et al. 2011 (elastography at 45 Hz, G 4.9 kPa)", ""},
    {"liver", 6000, 1060, 164, "Rouviere et al. 2006 (elastography, G 2.0 kPa)",
     "Gokgol et al. 2012 (cattle, needle)"},
    {"muscle", 12000, 1050, 2490, "Engler et al. 2004 (mouse, indentation at rest, 12 kPa)",
     "Taylor et al. 2012 (pig)"},
    {"skin", 6000, 1090, 0,
     "Pailler-Mattei et al. 2008 (with what lies below, indentation, 4.5 to 8 kPa)", ""},
};
enum { TISSUES = sizeof table / sizeof *table };

const tissue *tissue_find(const char *name)
{
    for (int i = 0; i < TISSUES; ++i) {
        if (strcmp(table[i].name, name) == 0) {
            return &table[i];
        }
    }
    return NULL;
}

void tissue_names(char *out, size_t size)
{
    size_t used = 0;
    for (int i = 0; i < TISSUES && used < size; ++i) {
        used += (size_t)snprintf(out + used, size - used, "%s%s", i > 0 ? ", " : "", table[i].name);
    }
}

void tissue_print(FILE *out)
{
    (void)fprintf(out, "%-9s %7s %8s %10s  source of E; of toughness\n", "tissue", "E, kPa",
                  "kg/m^3", "J/m^2");
    for (int i = 0; i < TISSUES; ++i) {
        const tissue *t = &table[i];
        char toughness[16] = "-";
        if (t->toughness > 0.0) {
            (void)snprintf(toughness, sizeof toughness, "%.4g", t->toughness);
        }
        (void)fprintf(out, "%-9s %7.4g %8.4g %10s  %s%s%s\n", t->name, 1e-3 * t->youngs_modulus,
                      t->density, toughness, t->modulus_source, t->toughness > 0.0 ? "; " : "",
                      t->toughness_source);
    }
    (void)fprintf(out,
                  "Densities: ICRU Report 44 (1989), gelatine as water. Poisson's ratio %.2f and "
                  "damping %.3g 1/s for all:\nsoft tissue is nearly incompressible, and %.2f is "
                  "what tetrahedra take without locking; the damping is\nchosen so that nothing "
                  "rings. Toughness is told only: no model tears. Values for one's own tissue:\n"
                  "softsim-fit, from a measured curve.\n",
                  tissue_poisson_ratio, tissue_damping, tissue_poisson_ratio);
}

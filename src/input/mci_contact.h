/* Reader of `face` and `port` lines: what touches boundary 0 from above. SPDX-License-Identifier: MIT */
#pragma once

#include "input/mci_lines.h"
#include "scene/scene.h"

/* Reads the current line "face [SHAPE] R [mirror|lambertian] [at=x,y]", "face [SHAPE] metal N K [at=x,y]" or
 * "port SHAPE n=N [at=x,y] [name=NAME]", with the cursor behind the keyword. CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_contact(struct cml_mci_reader *reader, bool port, struct cml_scene *scene);

/* Returns the number of ports, or of faces. */
int cml_mci_contacts_of(const struct cml_scene *scene, bool ports);

/* Lists the groups of keys of the i-th port or face that may be set, at most CML_MOST_KEY_PARTS, in `part`.
 */
void cml_mci_contact_parts(struct cml_scene *scene, bool port, int i, struct cml_key_part *part);

/* Fills in names of ports, and checks all faces and ports together. Call it when all numbers are known.
 * CML_E_INPUT. */
CML_NODISCARD cml_status cml_mci_end_contacts(const struct cml_mci_reader *reader, struct cml_scene *scene);

/* Finds the port that a beam or detector, the owner, names in a line of `file`: *contact, from 1; 0 if name
 * is NULL. CML_E_INPUT: there is no such port. */
CML_NODISCARD cml_status cml_mci_find_port(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                                           const char *name, const char *owner, const char *file, int line,
                                           int *contact);

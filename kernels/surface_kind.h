/* How a boundary is represented. SPDX-License-Identifier: MIT */
#ifndef CML_SURFACE_KIND_H
#define CML_SURFACE_KIND_H

enum cml_surface_kind {
    CML_SURFACE_PLANE,
    CML_SURFACE_CONE, /* rings of capped cones about the z axis */
    CML_SURFACE_MESH,
    CML_SURFACE_AUTO, /* the kind of no surface: asks the host to choose one */
};

#endif

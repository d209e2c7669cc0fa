/* Names of all functions with structures of other capacities (capacities.h, which includes this).
 */
#if defined(MUKCA_OTHER_CAPACITIES) && !defined(MUKCA_CAPACITIES_NAMES_H)
#define MUKCA_CAPACITIES_NAMES_H

#define MUKCA_SIZED_NAME(name, e, j, m, f) name##_##e##_##j##_##m##_##f
#define MUKCA_SIZED_AS(name, e, j, m, f) MUKCA_SIZED_NAME(name, e, j, m, f)
#define MUKCA_SIZED(name) \
    MUKCA_SIZED_AS(name, MUKCA_MAX_ELEMENTS, MUKCA_MAX_JOINTS, MUKCA_MAX_MASSES, MUKCA_MAX_EFFECTS)
#define mukca_chain_joint_name MUKCA_SIZED(mukca_chain_joint_name)
#define mukca_chain_find_joint MUKCA_SIZED(mukca_chain_find_joint)
#define mukca_chain_find_element MUKCA_SIZED(mukca_chain_find_element)
#define mukca_chain_theta MUKCA_SIZED(mukca_chain_theta)
#define mukca_geometry_set MUKCA_SIZED(mukca_geometry_set)
#define mukca_geometry_theta MUKCA_SIZED(mukca_geometry_theta)
#define mukca_fk_position MUKCA_SIZED(mukca_fk_position)
#define mukca_fk_positions MUKCA_SIZED(mukca_fk_positions)
#define mukca_fk_pose MUKCA_SIZED(mukca_fk_pose)
#define mukca_fk_frames MUKCA_SIZED(mukca_fk_frames)
#define mukca_fk_jacobian MUKCA_SIZED(mukca_fk_jacobian)
#define mukca_fk_parameter_jacobian MUKCA_SIZED(mukca_fk_parameter_jacobian)
#define mukca_chain_load MUKCA_SIZED(mukca_chain_load)
#define mukca_chain_masses MUKCA_SIZED(mukca_chain_masses)
#define mukca_chain_moments MUKCA_SIZED(mukca_chain_moments)
#define mukca_effects_displacement MUKCA_SIZED(mukca_effects_displacement)
#define mukca_effect_unit MUKCA_SIZED(mukca_effect_unit)
#define mukca_row_state_start MUKCA_SIZED(mukca_row_state_start)
#define mukca_row_state_stream MUKCA_SIZED(mukca_row_state_stream)
#define mukca_row_state_next MUKCA_SIZED(mukca_row_state_next)
#define mukca_row_state_set MUKCA_SIZED(mukca_row_state_set)
#define mukca_corrected_parse MUKCA_SIZED(mukca_corrected_parse)
#define mukca_corrected_load MUKCA_SIZED(mukca_corrected_load)
#define mukca_corrected_position MUKCA_SIZED(mukca_corrected_position)
#define mukca_corrected_pose MUKCA_SIZED(mukca_corrected_pose)
#define mukca_corrected_jacobian MUKCA_SIZED(mukca_corrected_jacobian)

#endif

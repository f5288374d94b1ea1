# Compiler options every target of repose is built with.
add_library(repose_options INTERFACE)
target_compile_features(repose_options INTERFACE cxx_std_20)
# Same bits whatever the optimiser does: no contraction into fused multiply-add, no fast-math anywhere.
target_compile_options(repose_options INTERFACE -ffp-contract=off)
target_compile_options(repose_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                       -Woverloaded-virtual -Wold-style-cast -Wunused
                       -Wno-missing-field-initializers)  # options are aggregates with defaults
if(REPOSE_WARNINGS_AS_ERRORS)
  target_compile_options(repose_options INTERFACE -Werror)
endif()
if(REPOSE_SANITIZE)
  target_compile_options(repose_options INTERFACE -fsanitize=${REPOSE_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(repose_options INTERFACE -fsanitize=${REPOSE_SANITIZE})
endif()

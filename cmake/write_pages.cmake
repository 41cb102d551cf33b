# cmake -DPROGRAM=... -DTO=DIR -P write_pages.cmake: manual pages and completion, as the program writes
# them, below DIR as they lie below the prefix. GZIP, where given, compresses the pages.
function(printed variable)
  execute_process(COMMAND ${PROGRAM} config ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

function(write_manual name)
  printed(page --manual ${name})
  file(WRITE ${TO}/man/man1/${name}.1 "${page}")
  if(GZIP)
    execute_process(COMMAND ${GZIP} -9nf ${TO}/man/man1/${name}.1 COMMAND_ERROR_IS_FATAL ANY)
  endif()
endfunction()

# The first page names all others.
file(REMOVE_RECURSE ${TO}/man)
write_manual(orbweave)
printed(page --manual orbweave)
string(REPLACE "\\-" "-" page "${page}")
string(REGEX MATCHALL "\n\\.BR [a-z-]+" references "${page}")
foreach(reference IN LISTS references)
  string(REGEX REPLACE "\n\\.BR " "" name "${reference}")
  write_manual(${name})
endforeach()

printed(text --completion bash)
file(WRITE ${TO}/bash-completion/completions/orbweave "${text}")
printed(text --completion zsh)
file(WRITE ${TO}/zsh/vendor-completions/_orbweave "${text}")
printed(text --completion fish)
file(WRITE ${TO}/fish/vendor_completions.d/orbweave.fish "${text}")

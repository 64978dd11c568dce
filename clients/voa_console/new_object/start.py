"""Beginning of the page: a mesh file is dropped, or a new object is opened that somebody has begun."""

from nicegui import events, ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.draft import ENDINGS, MOST_BYTES, file_name
from voa_console.new_object.process import TaskFailed
from voa_console.new_object.workshop import Workshop

_ENDINGS = f"{', '.join(ending.upper() for ending in ENDINGS[:-1])} or {ENDINGS[-1].upper()}"
_MOST_MB = MOST_BYTES // 1_000_000
_STYLE = """
.voa-drop { border: 2px dashed rgba(128, 128, 128, 0.8); border-radius: 8px; }
.voa-drop .q-uploader__header { background: transparent; color: inherit; }
.voa-drop .q-uploader__list { min-height: 0; padding: 0; }
"""
_SENDING = """
<div v-for="file in props.files" :key="file.__key" class="q-pa-sm text-center">{{ file.name }}</div>
"""


def draw_start(workshop: Workshop, key: str | None) -> None:
    """Draw the field for a mesh file, and below it the new objects that were begun.

    Args:
        workshop: with them.
        key: that the browser gave; None: the console's own.
    """
    ui.add_css(_STYLE)
    with ui.card().classes("w-full gap-3"):
        ui.label(
            "From the mesh of an object come its rests, grasps, their scores and places for the lidar. "
            f"It may be a file in the format {_ENDINGS}, of at most {_MOST_MB} MB."
        )
        message = ui.label().classes("text-negative").props('role="alert"')
        busy = ui.spinner(size="md")
        busy.set_visibility(False)

        async def received(event: events.UploadEventArguments) -> None:
            message.set_text("")
            busy.set_visibility(True)
            try:
                bench = await _begun(workshop, key, event)
            except (TaskFailed, ValueError) as error:
                message.set_text(str(error))
                upload.reset()
            else:
                ui.navigate.to(f"/new?of={bench.id}")
            finally:
                busy.set_visibility(False)

        upload = ui.upload(
            auto_upload=True,
            max_files=1,
            max_file_size=MOST_BYTES,
            on_upload=received,
            on_rejected=lambda: message.set_text(
                f"Expected one file of at most {_MOST_MB} MB that ends with {', '.join(ENDINGS)}."
            ),
        )
        upload.props(f'accept="{",".join(f".{ending}" for ending in ENDINGS)}" flat').classes("w-full voa-drop")
        with upload.add_slot("header"):
            _draw_field()
        upload.add_slot("list", _SENDING)
    _begun_before(workshop, key)


def _draw_field() -> None:
    """Draw the content of the area into which a file is dropped, in place of the uploader's figures.

    It consists of elements, not of a template: NiceGUI makes the elements of a template again at every change of the
    page, and a button that is made again loses the focus of the keyboard.
    """
    with ui.column().classes("w-full items-center gap-2 p-6"):
        ui.icon("upload_file", size="lg")
        ui.label("Drop the mesh file here, or").classes("text-base")
        choose = ui.button("Choose a mesh file", icon="folder_open").props("no-caps")
        choose.on("click", js_handler="(event) => props.pickFiles(event)")
        with choose:
            ui.element("q-uploader-add-trigger")


async def _begun(workshop: Workshop, key: str | None, event: events.UploadEventArguments) -> Bench:
    """Begin with the file that was received; raises TaskFailed or ValueError with a sentence."""
    if event.file.size() > MOST_BYTES:
        raise ValueError(f"The file is larger than {MOST_BYTES // 1_000_000} MB: simplify the mesh.")
    name = file_name(event.file.name)
    bench = await workshop.new(key)
    mesh = bench.folder / "mesh" / name
    await event.file.save(mesh)
    try:
        await bench.take(mesh)
    except TaskFailed:
        await workshop.remove(bench)
        raise
    return bench


def _begun_before(workshop: Workshop, key: str | None) -> None:
    """Draw a line for each new object that was begun, with the progress of its scenario."""
    column = ui.column().classes("w-full gap-2")
    shown: list[tuple[str, str]] = []

    def update() -> None:
        lines = [(bench.id, _state(bench)) for bench in workshop.benches(key)]
        if lines == shown:
            return
        shown[:] = lines
        column.clear()
        with column:
            for id_, text in lines:
                with ui.row().classes("items-center gap-3"):
                    ui.label(text)
                    ui.link("Continue", f"/new?of={id_}").props["aria-label"] = f"Continue with {text}"

    update()
    ui.timer(1.0, update)


def _state(bench: Bench) -> str:
    """Describe a new object in a line."""
    job = bench.job
    if job is None:
        return f"{bench.name}: begun"
    if job.state != "running":
        return f"{bench.name}: {job.state}"
    share = job.share
    return f"{bench.name}: {job.text}" + ("" if share is None else f", {share:.0%}")

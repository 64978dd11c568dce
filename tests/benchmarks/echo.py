"""The peer of the service's benchmark: FastAPI and pydantic with the same bodies, in a `def` endpoint, and no work."""

import argparse
import socket

import uvicorn
from fastapi import FastAPI, Request

from voa_msgs.sessions import ScanRequest, Session, UpdatedSession


def create_app() -> FastAPI:
    """Build an application that returns its stored bodies: a session, and the answer to every scan."""
    app = FastAPI()
    kept: list[UpdatedSession] = []

    @app.get("/readyz")
    def ready() -> bool:
        return True

    @app.post("/prepare")
    async def prepare(request: Request) -> None:
        kept[:] = [UpdatedSession.model_validate_json(await request.body())]

    @app.post("/scans")
    def scans(request: ScanRequest) -> UpdatedSession:
        return kept[0]

    session: list[Session] = []

    @app.put("/session")
    async def put_session(request: Request) -> None:
        session[:] = [Session.model_validate_json(await request.body())]

    @app.get("/session")
    def get_session() -> Session:
        return session[0]

    return app


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--fd", type=int, required=True)
    listening = socket.socket(fileno=parser.parse_args().fd)
    config = uvicorn.Config(create_app(), log_level="warning", access_log=False)
    uvicorn.Server(config).run([listening])
